// SPDX-License-Identifier: Apache-2.0
// What the device refuses, and that a refusal leaves nothing behind. No tolerances.
#include "render/vulkan/vulkan_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>

#include "twin/base/errors.hpp"
#include "twin/base/out_of_memory.hpp"

namespace fringetwin::render::vulkan_device_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class VulkanDeviceTest : public ::testing::Test {
 protected:
  static bool required() { return std::getenv("CI") || std::getenv("FRINGETWIN_REQUIRE_DEVICE"); }
  void SetUp() override {
    if (!list_devices().empty()) return;
    if (required()) FAIL() << "no Vulkan device found";
    GTEST_SKIP() << "no Vulkan device found";
  }
};

template <class F>
std::string refusal(F f) {
  try {
    f();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::device);
    return e.what();
  }
  return "";
}

/// While it lives, the process gets at most `more` bytes of further address space.
class AddressLimit {
 public:
  explicit AddressLimit(std::size_t more) {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    getrlimit(RLIMIT_AS, &before_);
    const rlimit limit{pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + more, before_.rlim_max};
    setrlimit(RLIMIT_AS, &limit);
  }
  ~AddressLimit() { setrlimit(RLIMIT_AS, &before_); }
  AddressLimit(const AddressLimit&) = delete;
  AddressLimit& operator=(const AddressLimit&) = delete;

 private:
  rlimit before_{};
};

TEST_F(VulkanDeviceTest, RefusesLargerStorageThanItBinds) {
  VulkanDevice device("");
  const std::size_t most = device.limits().maxStorageBufferRange;
  EXPECT_THAT(refusal([&] { Buffer(device, most + 1, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT); }),
              HasSubstr("exceeds its storage buffers"));
  EXPECT_EQ(refusal([&] { Buffer(device, 1024, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT); }), "");
}

TEST_F(VulkanDeviceTest, RefusesMoreStorageBuffersThanItBinds) {
  VulkanDevice device("");
  const std::vector<VkDescriptorType> types(
      std::size_t{device.limits().maxPerStageDescriptorStorageBuffers} + 1,
      VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  EXPECT_THAT(refusal([&] { ComputePipeline(device, {}, types, {}, 4, VK_NULL_HANDLE); }),
              HasSubstr("storage buffers, this scene needs"));
}

class Staging {
 public:
  explicit Staging(bool on) { setenv("FRINGETWIN_STAGING", on ? "1" : "0", 1); }
  ~Staging() { unsetenv("FRINGETWIN_STAGING"); }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;
};

// Memory that the host can map; of memory that it reaches through a staging buffer all is cleared.
TEST_F(VulkanDeviceTest, ClearsPartsWhereItReachesThem) {
  const std::vector<std::uint32_t> before{1, 2, 3, 4, 5, 6, 7, 8};
  constexpr std::size_t kBytes = sizeof(std::uint32_t);
  for (const bool staging : {false, true}) {
    const Staging of_test(staging);
    VulkanDevice device("");
    Buffer buffer(device, before.size() * kBytes,
                  VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    buffer.upload(before);
    const std::vector<Buffer::Part> parts{{kBytes, 2 * kBytes}, {6 * kBytes, kBytes}};
    buffer.clear(parts);
    std::vector<std::uint32_t> found(before.size());
    std::memcpy(found.data(), buffer.read(before.size() * kBytes), before.size() * kBytes);
    EXPECT_EQ(found, staging ? std::vector<std::uint32_t>(before.size(), 0)
                             : std::vector<std::uint32_t>({1, 0, 0, 4, 5, 6, 0, 8}));
  }
}

// The process may grow by 64 MB and asks for 1 GB: the buffer exists by then, its memory does not. The
// validation layer tells on the device's end what was not released.
TEST_F(VulkanDeviceTest, AFailedBufferLeavesNothingBehind) {
  setenv("FRINGETWIN_VALIDATION", "1", 1);
  ::testing::internal::CaptureStderr();
  std::string no_layers;
  bool failed = false;
  try {
    VulkanDevice device("");
    const AddressLimit limit(64 << 20);
    try {
      const Buffer buffer(device, std::size_t{1} << 30, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    } catch (const OutOfMemory&) {
      failed = true;
    }
  } catch (const UserError& e) {
    no_layers = e.what();
  }
  const std::string messages = ::testing::internal::GetCapturedStderr();
  unsetenv("FRINGETWIN_VALIDATION");
  if (!no_layers.empty() && !required()) GTEST_SKIP() << no_layers;
  EXPECT_EQ(no_layers, "");
  EXPECT_THAT(messages, Not(HasSubstr("has not been destroyed")));
  if (!failed) GTEST_SKIP() << "this driver's memory is no address space of the process (Mesa 25)";
}

}  // namespace
}  // namespace fringetwin::render::vulkan_device_test
