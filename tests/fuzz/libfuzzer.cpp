// SPDX-License-Identifier: Apache-2.0
// The targets for libFuzzer: FRINGETWIN_TARGET names the one that runs, FRINGETWIN_SOURCE the checkout.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/fuzz/mutate.hpp"
#include "tests/fuzz/target.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::fuzz {
namespace {

const char* variable(const char* name) {
  const char* value = std::getenv(name);
  if (value) return value;
  std::fprintf(stderr, "%s is not set\n", name);
  std::exit(2);
}

const Target& chosen() {
  static const Target* target = find_target(variable("FRINGETWIN_TARGET"));
  if (target) return *target;
  std::fprintf(stderr, "FRINGETWIN_TARGET is no target; there are:");
  for (const Target* one : all_targets()) std::fprintf(stderr, " %s", one->name);
  std::exit(2);
}

}  // namespace
}  // namespace fringetwin::fuzz

using namespace fringetwin::fuzz;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  ::setenv("FRINGETWIN_CACHE", "", 1);
  ::setenv("FRINGETWIN_CAPTURES", "/nowhere", 1);  // large images are good, but read slowly
  fringetwin::set_quiet(true);
  set_source_folder(variable("FRINGETWIN_SOURCE"));
  work_folder();  // whose name then outlives the handler
  std::atexit(remove_work_folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read_checked(chosen(), std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}

/// One change in three is ours, which knows the format; an empty corpus begins with the seeds.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  static const std::vector<std::string> seeds = seeds_of(chosen());
  Random random(seed);
  if (size > 1 && !random.one_in(3)) return LLVMFuzzerMutate(data, size, max_size);
  const std::string input = size > 1 && !random.one_in(50)
                                ? std::string(reinterpret_cast<const char*>(data), size)
                                : random.of(seeds);
  const Mutator mutate = chosen().mutate && random.one_in(2) ? chosen().mutate : mutate_bytes;
  std::string output = random.one_in(4) ? insert_word(input, chosen().words, random) : mutate(input, random);
  output.resize(std::min(output.size(), max_size));
  std::memcpy(data, output.data(), output.size());
  return output.size();
}
