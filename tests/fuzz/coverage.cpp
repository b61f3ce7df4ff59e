// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/coverage.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#ifdef __clang__
#define FRINGETWIN_UNWATCHED __attribute__((no_sanitize("address", "undefined", "coverage")))
#else
#define FRINGETWIN_UNWATCHED __attribute__((no_sanitize("address", "undefined"), no_sanitize_coverage))
#endif

namespace fringetwin::fuzz {
namespace {

/// A bit a place would be a race between threads; a byte is none that matters. The libraries have some
/// 300,000 branches, a target a few thousand: few of these share a place.
constexpr std::size_t kPlaces = 1 << 16;
std::array<std::uint64_t, kPlaces / 8> ran, known;

}  // namespace

void begin_coverage() { ran.fill(0); }

bool found_new_code() {
  bool any = false;
  for (std::size_t i = 0; i < ran.size(); ++i) {
    any = any || (ran[i] & ~known[i]) != 0;
    known[i] |= ran[i];
  }
  return any;
}

namespace {
/// Called millions of times a second, by code that is being watched: no call from here.
FRINGETWIN_UNWATCHED inline void mark(const void* place) {
  const auto hash = reinterpret_cast<std::uintptr_t>(place) * 0x9e3779b97f4a7c15u;
  reinterpret_cast<unsigned char*>(ran.data())[hash >> 48] = 1;
}
}  // namespace

}  // namespace fringetwin::fuzz

extern "C" void __sanitizer_cov_trace_pc() FRINGETWIN_UNWATCHED;
extern "C" void __sanitizer_cov_trace_pc() { fringetwin::fuzz::mark(__builtin_return_address(0)); }
