// SPDX-License-Identifier: Apache-2.0
// One mesh as the driver's own acceleration structure: triangles below, one instance above.
#pragma once
#include <array>
#include <memory>

#include "render/vulkan/vulkan_device.hpp"

namespace fringetwin::bench {

/// One level, built on the device.
class AccelerationLevel {
 public:
  AccelerationLevel(render::VulkanDevice& device, VkAccelerationStructureTypeKHR type,
                    const VkAccelerationStructureGeometryKHR& geometry, std::uint32_t n_primitives);
  ~AccelerationLevel();
  AccelerationLevel(const AccelerationLevel&) = delete;
  AccelerationLevel& operator=(const AccelerationLevel&) = delete;
  VkAccelerationStructureKHR handle() const { return handle_; }
  VkDeviceAddress address() const;
  std::size_t bytes() const { return storage_->bytes(); }

 private:
  render::VulkanDevice& device_;
  std::unique_ptr<render::Buffer> storage_;
  VkAccelerationStructureKHR handle_ = VK_NULL_HANDLE;
};

/// What the vertex buffer needs: 3 float vertices of 16 bytes each per triangle.
constexpr VkBufferUsageFlags kAccelerationInput =
    VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
    VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

/// Opaque triangles in the order of the buffer, one instance, hit from both sides.
class AccelerationStructure {
 public:
  /// `T_cam_object`: rows of the instance's transform.
  AccelerationStructure(render::VulkanDevice& device, const render::Buffer& triangles,
                        std::uint32_t n_triangles, const std::array<float, 12>& T_cam_object);
  VkAccelerationStructureKHR top() const { return top_->handle(); }
  std::size_t bytes() const { return bottom_->bytes() + top_->bytes(); }

 private:
  std::unique_ptr<AccelerationLevel> bottom_;
  std::unique_ptr<render::Buffer> instance_;
  std::unique_ptr<AccelerationLevel> top_;
};

/// Writes the top level into a binding of a pipeline's descriptor set.
void bind_acceleration_structure(const render::VulkanDevice& device, const render::ComputePipeline& pipeline,
                                 std::uint32_t binding, const AccelerationStructure& structure);

}  // namespace fringetwin::bench
