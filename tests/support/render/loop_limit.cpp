// SPDX-License-Identifier: Apache-2.0
#include "tests/support/render/loop_limit.hpp"

#include <cstring>

#include "loop_limit_spv.h"
#include "render/shaders/shared.h"

namespace fringetwin::testing {

std::uint32_t count_loop_iterations(render::VulkanDevice& device, std::uint32_t requested) {
  using render::gpu::Push;
  render::ComputePipeline kernel(device, loop_limit_spv, {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}, {},
                                 sizeof(Push), VK_NULL_HANDLE);
  render::Buffer status(device, sizeof(std::uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  kernel.bind({&status});
  Push push{};
  push.end_sample = requested;
  kernel.dispatch(1, std::as_bytes(std::span(&push, 1)));
  std::uint32_t count = 0;
  std::memcpy(&count, status.read(sizeof(count)), sizeof(count));
  return count;
}

}  // namespace fringetwin::testing
