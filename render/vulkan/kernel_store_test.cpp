// SPDX-License-Identifier: Apache-2.0
// Kernels made ahead: each once, whoever comes first; a failure is met by who needs it. No tolerances.
#include "render/vulkan/kernel_store.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <stdexcept>

namespace fringetwin::render::kernel_store_test {
namespace {

// #version 450; layout(local_size_x = 1) in; void main() {}
constexpr std::array<std::uint32_t, 35> nothing_spv{0x07230203,
                                                    0x00010000,
                                                    0,
                                                    5,
                                                    0,  // magic, version, generator, bound, schema
                                                    (2U << 16) | 17,
                                                    1,  // OpCapability Shader
                                                    (3U << 16) | 14,
                                                    0,
                                                    1,  // OpMemoryModel Logical GLSL450
                                                    (5U << 16) | 15,
                                                    5,
                                                    1,
                                                    0x6e69616d,
                                                    0,  // OpEntryPoint GLCompute %1 "main"
                                                    (6U << 16) | 16,
                                                    1,
                                                    17,
                                                    1,
                                                    1,
                                                    1,  // OpExecutionMode %1 LocalSize 1 1 1
                                                    (2U << 16) | 19,
                                                    2,  // %2 = OpTypeVoid
                                                    (3U << 16) | 33,
                                                    3,
                                                    2,  // %3 = OpTypeFunction %2
                                                    (5U << 16) | 54,
                                                    2,
                                                    1,
                                                    0,
                                                    3,  // %1 = OpFunction %2 None %3
                                                    (2U << 16) | 248,
                                                    4,
                                                    (1U << 16) | 253,
                                                    (1U << 16) | 56};  // OpLabel, OpReturn, OpFunctionEnd

class KernelStoreTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!list_devices().empty()) return;
    if (std::getenv("CI") || std::getenv("FRINGETWIN_REQUIRE_DEVICE")) FAIL() << "no Vulkan device found";
    GTEST_SKIP() << "no Vulkan device found";
  }
  static KernelStore::Key key(std::uint32_t i) {
    KernelStore::Key k{Kernel::trace, false, false, {}};
    std::get<3>(k)[0] = i;
    return k;
  }
  static std::unique_ptr<ComputePipeline> kernel(VulkanDevice& device) {
    return std::make_unique<ComputePipeline>(device, nothing_spv,
                                             std::vector{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                             std::vector<std::uint32_t>{}, 4, VK_NULL_HANDLE);
  }
};

TEST_F(KernelStoreTest, MakesEachOnceWhoeverComesFirst) {
  VulkanDevice device("");
  constexpr std::uint32_t n = 12;
  for (int round = 0; round < 20; ++round) {
    std::array<std::atomic<int>, n> made{};
    KernelStore store([&](const KernelStore::Key& k) {
      ++made[std::get<3>(k)[0]];
      return kernel(device);
    });
    std::vector<KernelStore::Key> keys;
    for (std::uint32_t i = 0; i < n; ++i) keys.push_back(key(i));
    store.foresee(keys);
    std::array<ComputePipeline*, n> got{};
    for (std::uint32_t i = n; i-- > 0;) got[i] = &store.get(key(i));  // from the other end
    store.foresee(keys);
    for (std::uint32_t i = 0; i < n; ++i) {
      EXPECT_EQ(&store.get(key(i)), got[i]);
      EXPECT_EQ(made[i], 1);
    }
  }
}

TEST_F(KernelStoreTest, AFailureIsMetByWhoNeedsTheKernel) {
  VulkanDevice device("");
  std::atomic<int> tries = 0;
  KernelStore store([&](const KernelStore::Key&) -> std::unique_ptr<ComputePipeline> {
    if (++tries < 3) throw std::runtime_error("no memory");
    return kernel(device);
  });
  store.foresee({key(0), key(1)});
  while (tries == 0) std::this_thread::yield();
  store.stop();
  EXPECT_EQ(tries, 1) << "nothing foreseen is tried after a failure";
  EXPECT_THROW(store.get(key(0)), std::runtime_error);
  EXPECT_NO_THROW(store.get(key(0)));
}

TEST_F(KernelStoreTest, StopsAfterTheOneInTheMaking) {
  VulkanDevice device("");
  std::atomic<int> begun = 0;
  std::atomic<bool> go = false;
  const std::jthread later([&] {
    while (begun == 0) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the store is being destroyed by then
    go = true;
  });
  {
    KernelStore store([&](const KernelStore::Key&) {
      ++begun;
      while (!go) std::this_thread::yield();
      return kernel(device);
    });
    store.foresee({key(0), key(1), key(2)});
    while (begun == 0) std::this_thread::yield();
  }
  EXPECT_EQ(begun, 1);
}

}  // namespace
}  // namespace fringetwin::render::kernel_store_test
