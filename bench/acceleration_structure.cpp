// SPDX-License-Identifier: Apache-2.0
#include "bench/acceleration_structure.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

namespace fringetwin::bench {

using render::Buffer;
using render::vk_check;
using render::VulkanDevice;

AccelerationLevel::AccelerationLevel(VulkanDevice& device, VkAccelerationStructureTypeKHR type,
                                     const VkAccelerationStructureGeometryKHR& geometry,
                                     std::uint32_t n_primitives)
    : device_(device) {
  VkAccelerationStructureBuildGeometryInfoKHR build{};
  build.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
  build.type = type;
  build.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
  build.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
  build.geometryCount = 1;
  build.pGeometries = &geometry;
  VkAccelerationStructureBuildSizesInfoKHR sizes{};
  sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
  vkGetAccelerationStructureBuildSizesKHR(device_.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                          &build, &n_primitives, &sizes);
  storage_ = std::make_unique<Buffer>(
      device_, sizes.accelerationStructureSize,
      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
  VkAccelerationStructureCreateInfoKHR create{};
  create.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
  create.buffer = storage_->handle();
  create.size = sizes.accelerationStructureSize;
  create.type = type;
  vk_check(vkCreateAccelerationStructureKHR(device_.handle(), &create, nullptr, &handle_),
           "vkCreateAccelerationStructureKHR");

  constexpr VkDeviceSize kScratchAlignment = 256;  // the most that a device may ask for
  Buffer scratch(device_, sizes.buildScratchSize + kScratchAlignment,
                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
  build.dstAccelerationStructure = handle_;
  build.scratchData.deviceAddress =
      (scratch.address() + kScratchAlignment - 1) / kScratchAlignment * kScratchAlignment;
  const VkAccelerationStructureBuildRangeInfoKHR range{n_primitives, 0, 0, 0};
  const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range;
  device_.run([&](VkCommandBuffer commands) {
    // What the level below or an upload wrote.
    VkMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_HOST_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    vkCmdBuildAccelerationStructuresKHR(commands, 1, &build, &ranges);
  });
}

AccelerationLevel::~AccelerationLevel() {
  if (handle_) vkDestroyAccelerationStructureKHR(device_.handle(), handle_, nullptr);
}

VkDeviceAddress AccelerationLevel::address() const {
  VkAccelerationStructureDeviceAddressInfoKHR info{};
  info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
  info.accelerationStructure = handle_;
  return vkGetAccelerationStructureDeviceAddressKHR(device_.handle(), &info);
}

AccelerationStructure::AccelerationStructure(VulkanDevice& device, const Buffer& triangles,
                                             std::uint32_t n_triangles,
                                             const std::array<float, 12>& T_cam_object) {
  VkAccelerationStructureGeometryKHR mesh{};
  mesh.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
  mesh.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
  mesh.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  auto& t = mesh.geometry.triangles;
  t.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
  t.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
  t.vertexData.deviceAddress = triangles.address();
  t.vertexStride = 4 * sizeof(float);
  t.maxVertex = 3 * n_triangles - 1;
  t.indexType = VK_INDEX_TYPE_NONE_KHR;
  bottom_ = std::make_unique<AccelerationLevel>(device, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, mesh,
                                                n_triangles);

  VkAccelerationStructureInstanceKHR instance{};
  static_assert(sizeof(instance.transform) == sizeof(T_cam_object));
  std::memcpy(&instance.transform, T_cam_object.data(), sizeof(instance.transform));
  instance.mask = 0xFF;
  instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
  instance.accelerationStructureReference = bottom_->address();
  instance_ = std::make_unique<Buffer>(device, sizeof(instance), kAccelerationInput);
  instance_->upload(std::as_bytes(std::span(&instance, 1)));
  VkAccelerationStructureGeometryKHR scene{};
  scene.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
  scene.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  scene.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
  scene.geometry.instances.data.deviceAddress = instance_->address();
  top_ = std::make_unique<AccelerationLevel>(device, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, scene, 1);
}

void bind_acceleration_structure(const VulkanDevice& device, const render::ComputePipeline& pipeline,
                                 std::uint32_t binding, const AccelerationStructure& structure) {
  const VkAccelerationStructureKHR top = structure.top();
  VkWriteDescriptorSetAccelerationStructureKHR value{};
  value.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR;
  value.accelerationStructureCount = 1;
  value.pAccelerationStructures = &top;
  VkWriteDescriptorSet write{};
  write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
  write.pNext = &value;
  write.dstSet = pipeline.set();
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
  vkUpdateDescriptorSets(device.handle(), 1, &write, 0, nullptr);
}

}  // namespace fringetwin::bench
