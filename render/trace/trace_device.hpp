// SPDX-License-Identifier: Apache-2.0
// The renderer's device side: buffers, pipelines and passes. Internal to render/ (includes volk).
#pragma once
#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "render/scene/shortcuts.hpp"
#include "render/trace/trace_job.hpp"
#include "render/vulkan/kernel_store.hpp"
#include "render/vulkan/vulkan_device.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::render {

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span<const T, 1>(&value, 1));
}

/// What one call of trace() works on.
struct TraceJob {
  const Twin& twin;
  const Camera& camera;
  const PackedScene& scene;
  const LensTable& lens;
  const ProjectorSetup& projector;
  const std::vector<std::uint32_t>& blocks;
  const Shortcuts& shortcuts;
  std::uint64_t seed;
  Progress* progress;
  Transport* out;
};

/// Where a pass's sums go: images in the order of the output channels (nullptr: not kept), each times
/// a factor.
struct SumTarget {
  ImageF* image;
  float factor;
};
std::vector<SumTarget> sum_targets(const Twin& twin, const PassPlan& pass, bool first_pass, Transport* out);

struct Renderer::Impl {
  explicit Impl(const std::string& wanted);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const LensTable& lens_table(const Lens& lens);
  /// Grows, never shrinks; a grown buffer loses its contents.
  Buffer& reserve(std::size_t binding, std::size_t bytes);
  template <class T>
  void fill(std::size_t binding, const std::vector<T>& data) {
    reserve(binding, data.size() * sizeof(T)).upload(data);
  }
  void upload_geometry(const PackedScene& scene, const Shortcuts& shortcuts, double reach_mm);
  void upload_scene(const TraceJob& job);
  void upload_samples(const SampleSetup& samples);
  /// Parameters and waveforms of one pass.
  void upload_pass(const TraceJob& job, const PassPlan& pass, const SampleSetup& samples,
                   const AdaptiveTargets& targets);
  KernelStore::Key kernel_key(Kernel kernel, const SpecConstants& constants) const {
    return {kernel, storage_geometry, precise, constants};
  }
  /// The specialised kernel with the present buffers bound.
  ComputePipeline& bound_kernel(Kernel kernel, const SpecConstants& constants);

  /// Runs once and returns false when an invocation was cut short by the driver's loop limit.
  bool dispatch(ComputePipeline& kernel, const gpu::Push& push, std::uint32_t groups, Transport* out);

  void trace_plain(const TraceJob& job, const std::vector<PassPlan>& passes, const SampleSetup& samples);
  void run_band(ComputePipeline& kernel, gpu::Push push, std::uint32_t n_samples, std::uint32_t groups,
                std::uint32_t* chunk, Transport* out);
  /// A band's sums, block by block, into the images.
  static void scatter_sums(const TraceJob& job, const std::vector<SumTarget>& targets, std::size_t first,
                           std::size_t n, const float* sums);
  /// The objects of a band of blocks into the object image.
  void scatter_objects(const TraceJob& job, std::size_t first, std::size_t n);

  VulkanDevice device;
  VkPipelineCache cache = VK_NULL_HANDLE;
  KernelStore kernels;
  std::array<std::unique_ptr<Buffer>, BIND_COUNT> buffers;
  std::vector<std::pair<Lens, std::unique_ptr<LensTable>>> lens_tables;
  MeshStore meshes;
  VisibilityStore visibility;
  bool search_always = false;
  bool storage_geometry = false;
  bool precise = false;
  std::uint32_t forced_chunk = 0, line_stretches = 1;
  int repeated = 0;
  PatternMethod pattern_method = PatternMethod::automatic;
};

/// The adaptive trace (adaptive_trace.cpp). Needs what can_trace_adaptively() says.
void trace_adaptively(Renderer::Impl& impl, const TraceJob& job, const std::vector<PassPlan>& passes,
                      const Sampling& sampling);
bool can_trace_adaptively(const Twin& twin, const Camera& camera, const PackedScene& scene,
                          const std::vector<PassPlan>& passes, const VkPhysicalDeviceLimits& limits);
/// Thrown by trace_adaptively() where the driver cuts an invocation's loops.
struct LoopLimit {};

}  // namespace fringetwin::render
