// SPDX-License-Identifier: Apache-2.0
// Implements the Buffer and ComputePipeline of vulkan_device.hpp.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "render/vulkan/vulkan_device.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr VkMemoryPropertyFlags kMappable =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

}  // namespace

Buffer::Buffer(VulkanDevice& device, std::size_t bytes, VkBufferUsageFlags usage, VkFormat texel_format)
    : Buffer(device, std::max<std::size_t>(bytes, 16)) {
  constexpr double kMb = 1024.0 * 1024.0;
  if ((usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) && bytes_ > device.limits().maxStorageBufferRange)
    throw UserError(
        ExitCode::device, device.info().name,
        fmt::format("a table of {:.0f} MB exceeds its storage buffers ({:.0f} MB)",
                    static_cast<double>(bytes_) / kMb, device.limits().maxStorageBufferRange / kMb),
        "use another device or a coarser mesh");
  const bool direct = device.has_mappable_device_memory();
  VkBufferUsageFlags transfer = 0;
  if (!direct) transfer = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkMemoryPropertyFlags required = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, preferred = 0;
  if (direct) {
    required |= kMappable;
    preferred = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  }
  allocate(usage | transfer, required, preferred, main_);
  buffer_ = main_.buffer;
  if (texel_format == VK_FORMAT_UNDEFINED) return;
  auto view = vk_struct<VkBufferViewCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO);
  view.buffer = buffer_;
  view.format = texel_format;
  view.range = VK_WHOLE_SIZE;
  vk_check(vkCreateBufferView(device_.handle(), &view, nullptr, &view_), "vkCreateBufferView");
}

Buffer::~Buffer() {
  if (view_) vkDestroyBufferView(device_.handle(), view_, nullptr);
  release(main_);
  release(staging_);
}

void Buffer::allocate(VkBufferUsageFlags usage, VkMemoryPropertyFlags required,
                      VkMemoryPropertyFlags preferred, Allocation& a) {
  auto create = vk_struct<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  create.size = bytes_;
  create.usage = usage;
  vk_check(vkCreateBuffer(device_.handle(), &create, nullptr, &a.buffer), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_.handle(), a.buffer, &needs);
  auto flags = vk_struct<VkMemoryAllocateFlagsInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO);
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  auto memory = vk_struct<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  if (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) memory.pNext = &flags;
  memory.allocationSize = needs.size;
  memory.memoryTypeIndex = device_.memory_type(needs.memoryTypeBits, required, preferred);
  vk_check(vkAllocateMemory(device_.handle(), &memory, nullptr, &a.memory), "vkAllocateMemory");
  vk_check(vkBindBufferMemory(device_.handle(), a.buffer, a.memory, 0), "vkBindBufferMemory");
  if ((required & kMappable) == kMappable) {
    void* p = nullptr;
    vk_check(vkMapMemory(device_.handle(), a.memory, 0, VK_WHOLE_SIZE, 0, &p), "vkMapMemory");
    a.mapped = static_cast<std::byte*>(p);
  }
}

void Buffer::release(Allocation& a) {
  if (a.buffer) vkDestroyBuffer(device_.handle(), a.buffer, nullptr);
  if (a.memory) vkFreeMemory(device_.handle(), a.memory, nullptr);
  a = {};
}

VkDeviceAddress Buffer::address() const {
  auto info = vk_struct<VkBufferDeviceAddressInfo>(VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO);
  info.buffer = buffer_;
  return vkGetBufferDeviceAddress(device_.handle(), &info);
}

void Buffer::upload(std::span<const std::byte> data) {
  FT_CHECK(data.size() <= bytes_, "upload larger than the buffer");
  if (data.empty()) return;
  if (main_.mapped) {
    std::memcpy(main_.mapped, data.data(), data.size());
    return;
  }
  if (!staging_.buffer)
    allocate(VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, kMappable,
             VK_MEMORY_PROPERTY_HOST_CACHED_BIT, staging_);
  std::memcpy(staging_.mapped, data.data(), data.size());
  device_.run([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{0, 0, data.size()};
    vkCmdCopyBuffer(commands, staging_.buffer, buffer_, 1, &copy);
  });
}

void Buffer::clear() {
  device_.run([&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, buffer_, 0, VK_WHOLE_SIZE, 0); });
}

void Buffer::clear(std::span<const Part> parts) {
  for (const Part& part : parts) FT_CHECK(part.first + part.bytes <= bytes_, "a part within the buffer");
  if (!main_.mapped) return clear();
  for (const Part& part : parts) std::memset(main_.mapped + part.first, 0, part.bytes);
}

const std::byte* Buffer::read(std::size_t bytes) {
  FT_CHECK(bytes <= bytes_, "read beyond the buffer");
  if (main_.mapped) return main_.mapped;
  if (!staging_.buffer)
    allocate(VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, kMappable,
             VK_MEMORY_PROPERTY_HOST_CACHED_BIT, staging_);
  device_.run([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{0, 0, bytes};
    vkCmdCopyBuffer(commands, buffer_, staging_.buffer, 1, &copy);
  });
  return staging_.mapped;
}

ComputePipeline::ComputePipeline(VulkanDevice& device, std::span<const std::uint32_t> spirv,
                                 const std::vector<VkDescriptorType>& types,
                                 const std::vector<std::uint32_t>& constants, std::uint32_t push_bytes,
                                 VkPipelineCache cache)
    : ComputePipeline(device, types) {
  const auto n_storage = std::ranges::count(types, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  if (n_storage > static_cast<std::ptrdiff_t>(device.limits().maxPerStageDescriptorStorageBuffers))
    throw UserError(ExitCode::device, device.info().name,
                    fmt::format("it binds {} storage buffers, this scene needs {}",
                                device.limits().maxPerStageDescriptorStorageBuffers, n_storage),
                    "use another device");
  create_layout(push_bytes);
  create_pipeline(spirv, constants, cache);
  create_set();
}

void ComputePipeline::create_layout(std::uint32_t push_bytes) {
  std::vector<VkDescriptorSetLayoutBinding> bindings(types_.size());
  for (std::uint32_t i = 0; i < types_.size(); ++i)
    bindings[i] = {i, types_[i], 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  auto set_layout =
      vk_struct<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set_layout.bindingCount = static_cast<std::uint32_t>(bindings.size());
  set_layout.pBindings = bindings.data();
  vk_check(vkCreateDescriptorSetLayout(device_.handle(), &set_layout, nullptr, &set_layout_),
           "vkCreateDescriptorSetLayout");

  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_bytes};
  auto layout = vk_struct<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &set_layout_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  vk_check(vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &layout_), "vkCreatePipelineLayout");
}

void ComputePipeline::create_pipeline(std::span<const std::uint32_t> spirv,
                                      const std::vector<std::uint32_t>& constants, VkPipelineCache cache) {
  VkDevice d = device_.handle();
  auto module_info = vk_struct<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  module_info.codeSize = spirv.size_bytes();
  module_info.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  vk_check(vkCreateShaderModule(d, &module_info, nullptr, &module), "vkCreateShaderModule");
  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t i = 0; i < constants.size(); ++i)
    entries.push_back({i, i * static_cast<std::uint32_t>(sizeof(std::uint32_t)), sizeof(std::uint32_t)});
  const VkSpecializationInfo specialization{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                            constants.size() * sizeof(std::uint32_t), constants.data()};
  auto create = vk_struct<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  create.stage.module = module;
  create.stage.pName = "main";
  create.stage.pSpecializationInfo = constants.empty() ? nullptr : &specialization;
  create.layout = layout_;
  const VkResult result = vkCreateComputePipelines(d, cache, 1, &create, nullptr, &pipeline_);
  vkDestroyShaderModule(d, module, nullptr);
  vk_check(result, "vkCreateComputePipelines");
}

void ComputePipeline::create_set() {
  std::vector<VkDescriptorPoolSize> sizes;
  for (const VkDescriptorType type : types_) sizes.push_back({type, 1});
  auto pool = vk_struct<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.maxSets = 1;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  vk_check(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_), "vkCreateDescriptorPool");
  auto allocate = vk_struct<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout_;
  vk_check(vkAllocateDescriptorSets(device_.handle(), &allocate, &set_), "vkAllocateDescriptorSets");
}

ComputePipeline::~ComputePipeline() {
  VkDevice d = device_.handle();
  if (pool_) vkDestroyDescriptorPool(d, pool_, nullptr);
  if (pipeline_) vkDestroyPipeline(d, pipeline_, nullptr);
  if (layout_) vkDestroyPipelineLayout(d, layout_, nullptr);
  if (set_layout_) vkDestroyDescriptorSetLayout(d, set_layout_, nullptr);
}

void ComputePipeline::bind(const std::vector<const Buffer*>& buffers) {
  FT_CHECK(buffers.size() == types_.size(), "one buffer per binding");
  std::vector<VkDescriptorBufferInfo> infos(buffers.size());
  std::vector<VkBufferView> views(buffers.size());
  std::vector<VkWriteDescriptorSet> writes;
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    if (!buffers[i]) continue;
    infos[i] = {buffers[i]->handle(), 0, VK_WHOLE_SIZE};
    views[i] = buffers[i]->view();
    VkWriteDescriptorSet& write = writes.emplace_back();
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set_;
    write.dstBinding = static_cast<std::uint32_t>(i);
    write.descriptorCount = 1;
    write.descriptorType = types_[i];
    write.pBufferInfo = &infos[i];
    write.pTexelBufferView = &views[i];
  }
  vkUpdateDescriptorSets(device_.handle(), static_cast<std::uint32_t>(writes.size()), writes.data(), 0,
                         nullptr);
}

void ComputePipeline::dispatch(std::uint32_t groups, std::span<const std::byte> push) {
  device_.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       static_cast<std::uint32_t>(push.size()), push.data());
    vkCmdDispatch(commands, groups, 1, 1);
  });
}

}  // namespace fringetwin::render
