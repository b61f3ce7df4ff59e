// SPDX-License-Identifier: Apache-2.0
// Wraps what the renderer needs of Vulkan: instance and device, buffers and compute pipelines. Every VkResult
// that is a failure becomes a UserError(device). Internal to render/ (includes volk).
#pragma once
#include <volk.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/base/device_info.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::render {

/// Throws UserError(device), naming the call and the result, unless the result is VK_SUCCESS.
void vk_check(VkResult result, const char* call);

/// Returns a Vulkan structure with its type filled in and all else zero.
template <class T>
T vk_struct(VkStructureType type) {
  T made{};
  made.sType = type;
  return made;
}

/// A Vulkan 1.2 instance; validation layers when FRINGETWIN_VALIDATION=1.
class VulkanInstance : NotCopyable {
 public:
  VulkanInstance();
  ~VulkanInstance();
  /// Returns the devices with Vulkan 1.2 and a compute queue.
  std::vector<VkPhysicalDevice> devices() const;
  VkInstance handle() const { return instance_; }
  /// Returns the number of warnings and errors of the validation layers so far.
  int validation_messages() const { return *messages_; }

 private:
  // The public constructors delegate to one that does nothing: what they made before they throw is then
  // released by the destructor.
  struct Empty {};
  explicit VulkanInstance(Empty) {}

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::unique_ptr<std::atomic<int>> messages_ = std::make_unique<std::atomic<int>>(0);
};

/// Returns what the program tells of a device.
DeviceInfo describe_device(VkPhysicalDevice device);

/// What a device is opened with beyond the renderer's needs.
struct DeviceExtensions {
  std::vector<const char*> names;
  const void* features = nullptr;  ///< goes to VkDeviceCreateInfo::pNext
  /// Returns whether a device has all of it; null: nothing is asked for.
  bool (*offered)(VkPhysicalDevice) = nullptr;
};

/// One logical device with one compute queue.
class VulkanDevice : NotCopyable {
 public:
  /// Opens the device with `wanted` in its name, whatever the case; "" = $FRINGETWIN_DEVICE, else a CPU
  /// device, else the first. With `extensions` where the device offers them, see has_extensions().
  explicit VulkanDevice(const std::string& wanted, const DeviceExtensions& extensions = {});
  ~VulkanDevice();

  VkDevice handle() const { return device_; }
  const DeviceInfo& info() const { return info_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }
  const VulkanInstance& instance() const { return instance_; }
  /// Returns the index of a memory type with all of `required`, preferring those with `preferred`.
  std::uint32_t memory_type(std::uint32_t allowed, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags preferred) const;
  /// Returns true when the host can map the device's own memory; FRINGETWIN_STAGING=1 denies it.
  bool has_mappable_device_memory() const;
  bool has_double() const { return has_double_; }          ///< shaderFloat64
  bool has_extensions() const { return has_extensions_; }  ///< asked for, there and enabled
  /// Records commands with `record(VkCommandBuffer)`, submits, waits. They see all that the host or the
  /// device wrote before, and what they write is seen by all that follows.
  template <class Record>
  void run(Record record) {
    begin();
    record(commands_);
    submit_and_wait();
  }

 private:
  struct Empty {};
  explicit VulkanDevice(Empty) {}
  void create_device(std::uint32_t family, const DeviceExtensions& extensions);
  void begin();
  void submit_and_wait();

  VulkanInstance instance_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkPhysicalDeviceLimits limits_{};
  VkPhysicalDeviceMemoryProperties memory_{};
  DeviceInfo info_;
  bool has_double_ = false, has_extensions_ = false;
};

/// Device memory the host can fill and read: mapped where the device allows it, else through a
/// staging buffer (FRINGETWIN_STAGING=1 forces that path, for tests).
class Buffer : NotCopyable {
 public:
  /// Throws UserError(device) when the device holds no buffer of that size.
  Buffer(VulkanDevice& device, std::size_t bytes, VkBufferUsageFlags usage,
         VkFormat texel_format = VK_FORMAT_UNDEFINED);
  ~Buffer();

  VkBuffer handle() const { return buffer_; }
  VkBufferView view() const { return view_; }  ///< texel buffers
  VkDeviceAddress address() const;             ///< needs SHADER_DEVICE_ADDRESS usage
  std::size_t bytes() const { return bytes_; }
  void upload(std::span<const std::byte> data);
  void clear();  ///< all zero; needs TRANSFER_DST usage
  /// A part of the buffer, bytes.
  struct Part {
    std::size_t first = 0, bytes = 0;
  };
  /// Sets these parts to zero, or all where the host does not reach the memory: one command is cheaper than
  /// hundreds. Needs TRANSFER_DST usage.
  void clear(std::span<const Part> parts);
  template <class T>
  void upload(const std::vector<T>& data) {
    upload(std::as_bytes(std::span(data)));
  }
  /// Returns the first `bytes` of the buffer; valid until the next call of a Buffer function.
  const std::byte* read(std::size_t bytes);

 private:
  struct Allocation {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    std::byte* mapped = nullptr;
  };
  Buffer(VulkanDevice& device, std::size_t bytes) : device_(device), bytes_(bytes) {}
  void allocate(VkBufferUsageFlags usage, VkMemoryPropertyFlags required, VkMemoryPropertyFlags preferred,
                Allocation& allocation);
  void release(Allocation& allocation);

  VulkanDevice& device_;
  std::size_t bytes_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkBufferView view_ = VK_NULL_HANDLE;
  Allocation main_, staging_;
};

/// A compute pipeline with its own descriptor set.
class ComputePipeline : NotCopyable {
 public:
  /// `types[i]`: descriptor type of binding i; `constants`: specialization constants 0, 1, ...
  /// Throws UserError(device) when the device binds fewer storage buffers.
  ComputePipeline(VulkanDevice& device, std::span<const std::uint32_t> spirv,
                  const std::vector<VkDescriptorType>& types, const std::vector<std::uint32_t>& constants,
                  std::uint32_t push_bytes, VkPipelineCache cache);
  ~ComputePipeline();
  /// Binds one buffer per binding; nullptr leaves a binding to the caller, who writes it into set().
  void bind(const std::vector<const Buffer*>& buffers);
  VkDescriptorSet set() const { return set_; }
  /// Runs so many work groups with these push constants and waits for them.
  void dispatch(std::uint32_t groups, std::span<const std::byte> push);

 private:
  ComputePipeline(VulkanDevice& device, const std::vector<VkDescriptorType>& types)
      : device_(device), types_(types) {}
  void create_layout(std::uint32_t push_bytes);
  void create_pipeline(std::span<const std::uint32_t> spirv, const std::vector<std::uint32_t>& constants,
                       VkPipelineCache cache);
  void create_set();

  VulkanDevice& device_;
  std::vector<VkDescriptorType> types_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace fringetwin::render
