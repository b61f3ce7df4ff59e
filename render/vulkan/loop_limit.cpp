// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/loop_limit.hpp"

#include <cstring>

#include "loop_limit_spv.h"
#include "render/shaders/shared.h"

namespace fringetwin::render {

std::uint32_t count_loop_iterations(VulkanDevice& device, std::uint32_t requested) {
  ComputePipeline kernel(device, loop_limit_spv, {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}, {}, sizeof(gpu::Push),
                         VK_NULL_HANDLE);
  Buffer status(device, sizeof(std::uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  kernel.bind({&status});
  gpu::Push push{};
  push.end_sample = requested;
  kernel.dispatch(1, std::as_bytes(std::span(&push, 1)));
  std::uint32_t count = 0;
  std::memcpy(&count, status.read(sizeof(count)), sizeof(count));
  return count;
}

}  // namespace fringetwin::render
