// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/vulkan_device.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <cstring>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/base/out_of_memory.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/time_and_host.hpp"

namespace fringetwin::render {
namespace {

// Beyond the instance's 200 MB, a small camera takes 610 MB of lavapipe and of us with 2 threads. A thread,
// ours or lavapipe's, has 8 MB of stack.
constexpr std::uintmax_t kDriverMB = 576, kThreadMB = 16;
constexpr std::uint32_t kWantedApi = VK_API_VERSION_1_2;

const char* result_name(VkResult r) {
  constexpr std::pair<VkResult, const char*> kNames[] = {
      {VK_ERROR_OUT_OF_HOST_MEMORY, "out of host memory"},
      {VK_ERROR_OUT_OF_DEVICE_MEMORY, "out of device memory"},
      {VK_ERROR_DEVICE_LOST, "device lost"},
      {VK_ERROR_INITIALIZATION_FAILED, "initialisation failed"},
      {VK_ERROR_INCOMPATIBLE_DRIVER, "no driver"},
      {VK_ERROR_LAYER_NOT_PRESENT, "layer not present"},
      {VK_ERROR_EXTENSION_NOT_PRESENT, "extension not present"}};
  for (const auto& [result, name] : kNames)
    if (result == r) return name;
  return "failed";
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_validation(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                             VkDebugUtilsMessageTypeFlagsEXT,
                                             const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  if (severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT) {
    ++*static_cast<std::atomic<int>*>(user);
    warn(std::string("Vulkan validation: ") + data->pMessage);
  }
  return VK_FALSE;
}

/// Records a barrier that makes all writes before it, by the host or the device, visible to all that follows.
/// One barrier for everything is cheap, since there are few dispatches.
void full_barrier(VkCommandBuffer commands) {
  auto barrier = vk_struct<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_HOST_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_HOST_READ_BIT;
  constexpr VkPipelineStageFlags kStages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT;
  vkCmdPipelineBarrier(commands, kStages, kStages, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

bool has_compute_queue(VkPhysicalDevice device, std::uint32_t* family) {
  std::uint32_t n = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &n, nullptr);
  std::vector<VkQueueFamilyProperties> families(n);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &n, families.data());
  for (std::uint32_t i = 0; i < n; ++i)
    if (families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) {
      *family = i;
      return true;
    }
  return false;
}

/// Throws UserError(input) where the session leaves too few addresses: the compiler and the threads of
/// lavapipe crash when they get none.
void check_addresses() {
  const std::uintmax_t needed_mb = kDriverMB + kThreadMB * static_cast<unsigned>(omp_get_max_threads());
  const auto left = addresses_left();
  if (left && *left >> 20 < needed_mb)
    throw UserError(ExitCode::input, "Vulkan",
                    fmt::format("not enough memory, this session leaves the program {} MB of addresses, a "
                                "driver needs {}",
                                *left >> 20, needed_mb),
                    "raise ulimit -v, or use fewer threads (OMP_NUM_THREADS)");
}

}  // namespace

void vk_check(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  // The memory of a software device is the machine's: whose it was, the driver does not say reliably.
  if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY)
    throw OutOfMemory(fmt::format("Vulkan, {}: {}", call, result_name(result)));
  throw UserError(ExitCode::device, "Vulkan",
                  fmt::format("{}: {} (VkResult {})", call, result_name(result), static_cast<int>(result)),
                  "try another device with --device, see --device list");
}

VulkanInstance::VulkanInstance() : VulkanInstance(Empty{}) {
  const char* hint = "install mesa-vulkan-drivers for the CPU device (lavapipe)";
  if (volkInitialize() != VK_SUCCESS)
    throw UserError(ExitCode::device, "Vulkan", "the Vulkan loader (libvulkan.so.1) is not installed", hint);
  const bool validate = environment_value("FRINGETWIN_VALIDATION") == "1";
  auto app = vk_struct<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  app.pApplicationName = "fringetwin";
  app.apiVersion = kWantedApi;
  auto create = vk_struct<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  create.pApplicationInfo = &app;
  const char* layer = "VK_LAYER_KHRONOS_validation";
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  auto debug =
      vk_struct<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  debug.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  debug.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
  debug.pfnUserCallback = on_validation;
  debug.pUserData = messages_.get();
  if (validate) {
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &layer;
    create.enabledExtensionCount = 1;
    create.ppEnabledExtensionNames = &extension;
  }
  const VkResult result = vkCreateInstance(&create, nullptr, &instance_);
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    throw UserError(ExitCode::device, "Vulkan", "no Vulkan driver is installed", hint);
  if (result == VK_ERROR_LAYER_NOT_PRESENT)
    throw UserError(ExitCode::device, "Vulkan",
                    "FRINGETWIN_VALIDATION=1, but the validation layers are missing",
                    "install vulkan-validationlayers");
  vk_check(result, "vkCreateInstance");
  // Not volkLoadDevice: the loader's entry points serve several devices at once.
  volkLoadInstance(instance_);
  if (validate)
    vk_check(vkCreateDebugUtilsMessengerEXT(instance_, &debug, nullptr, &messenger_),
             "vkCreateDebugUtilsMessengerEXT");
}

VulkanInstance::~VulkanInstance() {
  if (messenger_) vkDestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
  if (instance_) vkDestroyInstance(instance_, nullptr);
}

std::vector<VkPhysicalDevice> VulkanInstance::devices() const {
  std::uint32_t n = 0;
  vk_check(vkEnumeratePhysicalDevices(instance_, &n, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> all(n);
  vk_check(vkEnumeratePhysicalDevices(instance_, &n, all.data()), "vkEnumeratePhysicalDevices");
  std::erase_if(all, [](VkPhysicalDevice d) {
    VkPhysicalDeviceProperties p;
    vkGetPhysicalDeviceProperties(d, &p);
    std::uint32_t family = 0;
    return p.apiVersion < kWantedApi || !has_compute_queue(d, &family);
  });
  return all;
}

DeviceInfo describe_device(VkPhysicalDevice device) {
  auto driver =
      vk_struct<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  auto p = vk_struct<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  p.pNext = &driver;
  vkGetPhysicalDeviceProperties2(device, &p);
  DeviceInfo info;
  info.name = p.properties.deviceName;
  info.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
  const std::uint32_t v = p.properties.apiVersion;
  info.api_version =
      fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(v), VK_API_VERSION_MINOR(v), VK_API_VERSION_PATCH(v));
  info.is_cpu = p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  VkPhysicalDeviceFeatures features{};
  vkGetPhysicalDeviceFeatures(device, &features);
  info.has_double = features.shaderFloat64 == VK_TRUE;
  return info;
}

std::vector<DeviceInfo> list_devices() {
  try {
    const VulkanInstance instance;
    std::vector<DeviceInfo> list;
    for (VkPhysicalDevice d : instance.devices()) list.push_back(describe_device(d));
    return list;
  } catch (const UserError&) {
    return {};
  }
}

VulkanDevice::VulkanDevice(const std::string& wanted, const DeviceExtensions& extensions)
    : VulkanDevice(Empty{}) {
  check_addresses();
  const auto devices = instance_.devices();
  if (devices.empty())
    throw UserError(ExitCode::device, "Vulkan", "there is no device with Vulkan 1.2 and a compute queue",
                    "install mesa-vulkan-drivers for the CPU device (lavapipe)");
  const std::string name = wanted.empty() ? environment_value("FRINGETWIN_DEVICE") : wanted;
  std::string names;
  for (VkPhysicalDevice d : devices) {
    const DeviceInfo info = describe_device(d);
    names += (names.empty() ? "" : ", ") + info.name;
    const bool fits =
        name.empty() ? info.is_cpu : lower_case(info.name).find(lower_case(name)) != std::string::npos;
    if (fits && !physical_) physical_ = d;
  }
  if (!physical_ && !name.empty())
    throw UserError(ExitCode::device, wanted.empty() ? "FRINGETWIN_DEVICE" : "--device",
                    fmt::format("no Vulkan device has \"{}\" in its name", name), "there is: " + names);
  if (!physical_) physical_ = devices.front();
  info_ = describe_device(physical_);
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical_, &properties);
  limits_ = properties.limits;
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);

  std::uint32_t family = 0;
  has_compute_queue(physical_, &family);
  create_device(family, extensions);
  vkGetDeviceQueue(device_, family, 0, &queue_);

  auto pool = vk_struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = family;
  vk_check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
  auto allocate = vk_struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  vk_check(vkAllocateCommandBuffers(device_, &allocate, &commands_), "vkAllocateCommandBuffers");
  auto fence = vk_struct<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  vk_check(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
}

void VulkanDevice::create_device(std::uint32_t family, const DeviceExtensions& extensions) {
  const float priority = 1.0F;
  auto queue = vk_struct<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceFeatures available{}, wanted_features{};
  vkGetPhysicalDeviceFeatures(physical_, &available);
  wanted_features.shaderFloat64 = available.shaderFloat64;
  has_double_ = available.shaderFloat64 == VK_TRUE;
  has_extensions_ = extensions.offered && extensions.offered(physical_);
  auto create = vk_struct<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  create.pEnabledFeatures = &wanted_features;
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  if (has_extensions_) {
    create.pNext = extensions.features;
    create.enabledExtensionCount = static_cast<std::uint32_t>(extensions.names.size());
    create.ppEnabledExtensionNames = extensions.names.data();
  }
  vk_check(vkCreateDevice(physical_, &create, nullptr, &device_), "vkCreateDevice");
}

VulkanDevice::~VulkanDevice() {
  if (!device_) return;
  if (fence_) vkDestroyFence(device_, fence_, nullptr);
  if (pool_) vkDestroyCommandPool(device_, pool_, nullptr);
  vkDestroyDevice(device_, nullptr);
}

std::uint32_t VulkanDevice::memory_type(std::uint32_t allowed, VkMemoryPropertyFlags required,
                                        VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags flags : {required | preferred, required})
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
      if ((allowed >> i & 1U) && (memory_.memoryTypes[i].propertyFlags & flags) == flags) return i;
  throw UserError(ExitCode::device, "Vulkan", "the device has no suitable memory type");
}

bool VulkanDevice::has_mappable_device_memory() const {
  if (environment_value("FRINGETWIN_STAGING") == "1") return false;
  constexpr VkMemoryPropertyFlags kFlags =
      VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
      VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
    if ((memory_.memoryTypes[i].propertyFlags & kFlags) == kFlags) return true;
  return false;
}

void VulkanDevice::begin() {
  auto begin = vk_struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  vk_check(vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
  full_barrier(commands_);
}

void VulkanDevice::submit_and_wait() {
  full_barrier(commands_);
  vk_check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  auto submit = vk_struct<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  // OpenMP's idle threads spin for a while and take the cores from a software driver's threads (a third of
  // the rendering time on 2 cores): they are sent home, the next parallel region calls new ones within 0.1
  // ms.
  if (info_.is_cpu) omp_pause_resource_all(omp_pause_soft);
  vk_check(vkQueueSubmit(queue_, 1, &submit, fence_), "vkQueueSubmit");
  vk_check(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  vk_check(vkResetFences(device_, 1, &fence_), "vkResetFences");
}

}  // namespace fringetwin::render
