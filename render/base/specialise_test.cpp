// SPDX-License-Identifier: Apache-2.0
// No tolerances. That the images are the same is what every other test of the renderer says: they were
// written for drivers that specialise.
#include "render/base/specialise.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <spirv-tools/libspirv.hpp>
#include <tuple>

#include "render/base/disk_cache.hpp"
#include "render/base/kernels.hpp"
#include "render/shaders/shared.h"

namespace fringetwin::render::specialise_test {
namespace {

namespace fs = std::filesystem;

std::vector<std::uint32_t> some_constants(std::uint32_t value) {
  std::vector<std::uint32_t> constants(SPEC_COUNT, value);
  constants[SPEC_FUNDAMENTALS] = ~0U;
  return constants;
}

TEST(Specialise, EveryKernelIsValidAndSmaller) {
  spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_2);
  std::string complaint;
  tools.SetMessageConsumer(
      [&](spv_message_level_t, const char*, const spv_position_t&, const char* text) { complaint = text; });
  for (const Kernel kernel :
       {Kernel::trace, Kernel::probe, Kernel::closed_form, Kernel::border, Kernel::facets, Kernel::lines})
    for (const auto& [storage, precise, value] :
         {std::tuple{false, false, 0U}, {false, false, 1U}, {true, true, 2U}}) {
      const auto code = kernel_code(kernel, storage, precise);
      const auto own = specialised(code, some_constants(value), {});
      ASSERT_FALSE(own.empty());
      EXPECT_TRUE(tools.Validate(own)) << static_cast<int>(kernel) << " " << value << ": " << complaint;
      EXPECT_LT(own.size(), code.size());
      if (value == 0) {
        EXPECT_LT(own.size(), code.size() * 6 / 10);
      }
    }
}

TEST(Specialise, IsKept) {
  const fs::path folder = fs::temp_directory_path() / ("fringetwin_specialise_" + std::to_string(::getpid()));
  const auto code = kernel_code(Kernel::probe, false, false);
  const auto first = specialised(code, some_constants(1), folder);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
  EXPECT_EQ(specialised(code, some_constants(1), folder), first);
  EXPECT_EQ(first, specialised(code, some_constants(1), {}));
  EXPECT_NE(first, specialised(code, some_constants(0), folder));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
  fs::remove_all(folder);
}

TEST(Specialise, WhatSomebodyElseKeptIsMadeAnew) {
  const fs::path folder = fs::temp_directory_path() / ("fringetwin_forged_" + std::to_string(::getpid()));
  const auto code = kernel_code(Kernel::probe, false, false);
  const auto own = specialised(code, some_constants(1), folder);
  const std::string name = fs::directory_iterator(folder)->path().stem();
  std::vector<std::uint32_t> cut(own.begin(), own.end() - 40), changed = own;
  for (std::size_t i = own.size() / 2; i < own.size(); i += 3) changed[i] ^= 0x10001U;
  for (const auto& forged :
       {cut, changed, std::vector<std::uint32_t>(300, 7), std::vector<std::uint32_t>{}}) {
    write_cached(folder, name, {std::as_bytes(std::span(forged))});  // with a right checksum
    EXPECT_EQ(specialised(code, some_constants(1), folder), own);
    EXPECT_EQ(read_cached(folder, name)->size(), 4 * own.size()) << "the file is mended";
  }
  specialised(code, some_constants(0), folder);
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().stem() != name)
      fs::copy_file(entry, folder / (name + ".cache"), fs::copy_options::overwrite_existing);
  EXPECT_EQ(specialised(code, some_constants(1), folder), own) << "another kernel's file";
  fs::remove(folder / (name + ".cache"));
  ASSERT_EQ(::mkfifo((folder / (name + ".cache")).c_str(), 0600), 0);
  EXPECT_EQ(specialised(code, some_constants(1), folder), own) << "a pipe";
  fs::remove_all(folder);
}

TEST(Specialise, WhatIsNoModuleGivesNothing) {
  const std::vector<std::uint32_t> nonsense(16, 42);
  EXPECT_TRUE(specialised(nonsense, some_constants(0), {}).empty());
}

}  // namespace
}  // namespace fringetwin::render::specialise_test
