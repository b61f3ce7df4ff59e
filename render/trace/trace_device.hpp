// SPDX-License-Identifier: Apache-2.0
// Runs the kernels of a trace: holds their buffers and the specialised kernels, takes what a trace reads to
// the device, dispatches, and reads back. Internal to render/ (includes volk).
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/trace/shader_params.hpp"
#include "render/trace/trace_job.hpp"
#include "render/vulkan/kernel_store.hpp"
#include "render/vulkan/vulkan_device.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::render {

/// The most memory that the sums of one dispatch may take.
constexpr std::size_t kMostOutputBytes = 64U << 20;

class TraceDevice : NotCopyable {
 public:
  /// `wanted`: as VulkanDevice has it. Throws UserError(device) also for a device whose work groups are too
  /// small.
  explicit TraceDevice(const std::string& wanted);
  ~TraceDevice();

  VulkanDevice& vulkan() { return vulkan_; }
  const VulkanDevice& vulkan() const { return vulkan_; }
  KernelStore& kernels() { return kernels_; }
  /// Chooses whether the kernels from now on trace in double precision; the device must have it.
  void set_precise(bool precise) { precise_ = precise; }
  bool precise() const { return precise_; }

  /// Returns the buffer of a binding with at least so many bytes. It grows, never shrinks; a grown buffer
  /// loses its contents.
  Buffer& reserve(std::size_t binding, std::size_t bytes);
  /// Copies `data` into the buffer of a binding.
  template <class T>
  void fill(std::size_t binding, const std::vector<T>& data) {
    reserve(binding, data.size() * sizeof(T)).upload(data);
  }
  /// Returns the first n values of a binding's buffer; valid until the buffer's next use.
  template <class T>
  const T* read(std::size_t binding, std::size_t n) {
    return reinterpret_cast<const T*>(buffers_[binding]->read(n * sizeof(T)));
  }

  /// Uploads what all passes of a trace read: geometry, materials, lenses, blocks.
  void upload_scene(const TraceJob& job);
  void upload_samples(const SampleSetup& samples);
  /// Uploads parameters and waveforms of one pass.
  void upload_pass(const TraceJob& job, const PassPlan& pass, const SampleSetup& samples,
                   const AdaptiveTargets& targets);

  /// Returns the key of a kernel in the present precision and with the present kind of geometry buffers.
  KernelStore::Key kernel_key(Kernel kernel, const SpecConstants& constants) const {
    return {kernel, storage_geometry_, precise_, constants};
  }
  /// Returns the specialised kernel with the present buffers bound.
  ComputePipeline& bound_kernel(Kernel kernel, const SpecConstants& constants);
  /// Runs a kernel once and adds its shadow rays to out->rays. Returns false, and adds nothing, when an
  /// invocation was cut short by the driver's loop limit.
  bool dispatch(ComputePipeline& kernel, const gpu::Push& push, std::uint32_t groups, Transport* out);

 private:
  void upload_meshes(const PackedScene& scene, double reach_mm);

  /// What the geometry buffers hold.
  struct UploadedMeshes {
    std::vector<std::pair<const MeshGeometry*, std::weak_ptr<const Mesh>>> meshes = {};
    float pad_mm = 0.0F;
    bool corners = false;
    bool same_as(const UploadedMeshes& other) const;
  };

  VulkanDevice vulkan_;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  KernelStore kernels_;
  std::array<std::unique_ptr<Buffer>, BIND_COUNT> buffers_;
  std::optional<UploadedMeshes> uploaded_;
  bool storage_geometry_ = false;  ///< geometry in storage buffers, because texel buffers are too small
  bool precise_ = false;
};

}  // namespace fringetwin::render
