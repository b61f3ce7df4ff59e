// SPDX-License-Identifier: Apache-2.0
#include "render/trace/trace_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "render/base/disk_cache.hpp"
#include "render/base/specialise.hpp"
#include "render/scene/pack_scene.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_of_memory.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/time_and_host.hpp"

namespace fringetwin::render {
namespace {

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span<const T, 1>(&value, 1));
}

constexpr VkDescriptorType kUniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
constexpr VkDescriptorType kTexels = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

struct BindingInfo {
  VkDescriptorType type;
  VkFormat format;
};
constexpr std::array<BindingInfo, BIND_COUNT> kBindings{{
    {kUniform, VK_FORMAT_UNDEFINED},           // params
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // primitives
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // materials
    {kTexels, VK_FORMAT_R32G32B32A32_SINT},    // nodes
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // triangles
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // corners
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // lens grid
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // projector grid
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // samples
    {kTexels, VK_FORMAT_R32G32B32A32_UINT},    // sobol
    {kTexels, VK_FORMAT_R32_SFLOAT},           // waveforms
    {kTexels, VK_FORMAT_R32_UINT},             // blocks
    {kStorage, VK_FORMAT_UNDEFINED},           // output
    {kStorage, VK_FORMAT_UNDEFINED},           // objects
    {kStorage, VK_FORMAT_UNDEFINED},           // status
    {kTexels, VK_FORMAT_R32_UINT},             // pixels
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // probe, read
    {kStorage, VK_FORMAT_UNDEFINED},           // probe, written: the same memory
    {kTexels, VK_FORMAT_R32G32B32A32_SINT},    // links
    {kTexels, VK_FORMAT_R32_SINT},             // starts
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // points that gather
    {kStorage, VK_FORMAT_UNDEFINED},           // places
    {kTexels, VK_FORMAT_R32_UINT},             // table of cells
    {kTexels, VK_FORMAT_R32_SFLOAT},           // light of cells
    {kStorage, VK_FORMAT_UNDEFINED},           // ways over shiny surfaces
    {kTexels, VK_FORMAT_R32G32B32A32_SFLOAT},  // places of these
}};

std::size_t texel_bytes(VkFormat format) {
  return format == VK_FORMAT_R32_SFLOAT || format == VK_FORMAT_R32_UINT || format == VK_FORMAT_R32_SINT ? 4
                                                                                                        : 16;
}

bool is_geometry(std::size_t binding) {
  return (binding >= BIND_NODES && binding <= BIND_CORNERS) || binding == BIND_LINKS;
}

// Makes a kernel with its code specialised; may run in any thread.
std::unique_ptr<ComputePipeline> make_kernel(VulkanDevice& device, VkPipelineCache cache,
                                             const KernelStore::Key& key) {
  const auto& [kernel, storage_geometry, precise, constants] = key;
  std::vector<VkDescriptorType> types;
  for (std::size_t i = 0; i < kBindings.size(); ++i)
    types.push_back(is_geometry(i) && storage_geometry ? kStorage : kBindings[i].type);
  const std::span<const std::uint32_t> code = kernel_code(kernel, storage_geometry, precise);
  const std::vector<std::uint32_t> own = specialised(code, constants, cache_folder());
  constexpr auto kPushBytes = static_cast<std::uint32_t>(sizeof(gpu::Push));
  if (!own.empty()) {
    try {
      return std::make_unique<ComputePipeline>(device, own, types, std::vector<std::uint32_t>{}, kPushBytes,
                                               cache);
    } catch (const UserError&) {    // not what we kept, or nothing that this driver takes
    } catch (const OutOfMemory&) {  // as some drivers call that
    }
  }
  return std::make_unique<ComputePipeline>(
      device, code, types, std::vector<std::uint32_t>(constants.begin(), constants.end()), kPushBytes, cache);
}

}  // namespace

TraceDevice::TraceDevice(const std::string& wanted)
    : vulkan_(wanted),
      kernels_([this](const KernelStore::Key& key) { return make_kernel(vulkan_, cache_, key); }) {
  if (vulkan_.limits().maxComputeWorkGroupInvocations < BLOCK_PIXELS)
    throw UserError(ExitCode::device, vulkan_.info().name,
                    fmt::format("its work groups hold {} invocations, the renderer needs {}",
                                vulkan_.limits().maxComputeWorkGroupInvocations, BLOCK_PIXELS));
  auto create = vk_struct<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
  vk_check(vkCreatePipelineCache(vulkan_.handle(), &create, nullptr, &cache_), "vkCreatePipelineCache");
}

TraceDevice::~TraceDevice() {
  kernels_.clear();
  vkDestroyPipelineCache(vulkan_.handle(), cache_, nullptr);
}

Buffer& TraceDevice::reserve(std::size_t binding, std::size_t bytes) {
  auto& slot = buffers_[binding];
  if (slot && slot->bytes() >= bytes) return *slot;
  const bool as_storage = kBindings[binding].type == kStorage || (is_geometry(binding) && storage_geometry_);
  const bool as_uniform = kBindings[binding].type == kUniform;
  VkBufferUsageFlags usage = as_storage   ? VK_BUFFER_USAGE_STORAGE_BUFFER_BIT
                             : as_uniform ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT
                                          : VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  if (binding == BIND_PROBE) usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const VkFormat format = as_storage || as_uniform ? VK_FORMAT_UNDEFINED : kBindings[binding].format;
  if (format != VK_FORMAT_UNDEFINED && bytes / texel_bytes(format) > vulkan_.limits().maxTexelBufferElements)
    throw UserError(ExitCode::device, vulkan_.info().name,
                    fmt::format("a table of {} elements exceeds its texel buffers ({})",
                                bytes / texel_bytes(format), vulkan_.limits().maxTexelBufferElements),
                    "use the CPU device");
  slot.reset();
  slot = std::make_unique<Buffer>(vulkan_, bytes, usage, format);
  return *slot;
}

// Uploads nodes and triangles of all meshes, one after the other, unless they are there. Boxes grow by the
// rounding of the slab test for rays that come from `reach_mm` away, rounded up to a power of two: so that a
// camera or projector that moves a little finds them, and what a trace reads does not depend on those before
// it.
void TraceDevice::upload_meshes(const PackedScene& scene, double reach_mm) {
  const auto pad = static_cast<float>(1e-6 * std::exp2(std::ceil(std::log2(std::max(reach_mm, 1e-3)))));
  std::size_t n_nodes = 0, n_vertices = 0;
  UploadedMeshes wanted{.pad_mm = pad, .corners = scene.corners};
  for (const MeshGeometry* m : scene.meshes) {
    n_nodes += m->bvh.nodes.size();
    n_vertices += m->triangles.size();
    wanted.meshes.emplace_back(m, m->mesh);
  }
  // FRINGETWIN_GEOMETRY=storage forces the variant for small devices, for tests.
  const bool needs_storage = std::max(4 * n_nodes, n_vertices) > vulkan_.limits().maxTexelBufferElements ||
                             environment_value("FRINGETWIN_GEOMETRY") == "storage";
  if (needs_storage != storage_geometry_) {
    storage_geometry_ = needs_storage;
    for (const std::size_t b : {BIND_NODES, BIND_TRIANGLES, BIND_CORNERS, BIND_LINKS}) buffers_[b].reset();
    uploaded_.reset();
  }
  if (uploaded_ && uploaded_->same_as(wanted)) return;
  uploaded_.reset();
  std::vector<BvhNode> nodes;
  std::vector<gpu::vec4> triangles, corners;
  nodes.reserve(n_nodes);
  triangles.reserve(n_vertices);
  for (const MeshGeometry* m : scene.meshes) {
    const std::size_t first = nodes.size();
    nodes.insert(nodes.end(), m->bvh.nodes.begin(), m->bvh.nodes.end());
    for (std::size_t i = first; i < nodes.size(); ++i) {
      nodes[i].left_min.array() -= pad;
      nodes[i].left_max.array() += pad;
      nodes[i].right_min.array() -= pad;
      nodes[i].right_max.array() += pad;
    }
    triangles.insert(triangles.end(), m->triangles.begin(), m->triangles.end());
    if (scene.corners) corners.insert(corners.end(), m->corners.begin(), m->corners.end());
  }
  fill(BIND_NODES, nodes);
  fill(BIND_TRIANGLES, triangles);
  fill(BIND_CORNERS, corners);
  uploaded_ = std::move(wanted);
}

bool TraceDevice::UploadedMeshes::same_as(const UploadedMeshes& other) const {
  if (pad_mm != other.pad_mm || corners != other.corners || meshes.size() != other.meshes.size())
    return false;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    // a mesh that is gone may have left its place to another
    const auto mesh = meshes[i].second.lock();
    if (!mesh || mesh != other.meshes[i].second.lock() || meshes[i].first != other.meshes[i].first)
      return false;
  }
  return true;
}

ComputePipeline& TraceDevice::bound_kernel(Kernel kernel, const SpecConstants& constants) {
  ComputePipeline& made = kernels_.get(kernel_key(kernel, constants));
  // Kernels that use no list, no probe or no cells get something to bind all the same.
  for (const std::size_t b : {BIND_PIXELS, BIND_PROBE, BIND_POINTS, BIND_PLACES, BIND_CELL_TABLE,
                              BIND_CELL_LIGHT, BIND_OBJECTS, BIND_WAYS, BIND_MIRRORS})
    if (!buffers_[b]) reserve(b, 16);
  std::vector<const Buffer*> bound;
  for (std::size_t b = 0; b < BIND_COUNT; ++b)
    bound.push_back(b == BIND_PROBE_OUT ? buffers_[BIND_PROBE].get() : buffers_[b].get());
  made.bind(bound);
  return made;
}

bool TraceDevice::dispatch(ComputePipeline& kernel, const gpu::Push& push, std::uint32_t groups,
                           Transport* out) {
  throw_if_cancelled();
  Buffer& status = *buffers_[BIND_STATUS];
  status.upload(std::vector<std::uint32_t>{0, 0, 0});
  kernel.dispatch(groups, bytes_of(push));
  std::array<std::uint32_t, 3> answer{};
  std::memcpy(answer.data(), status.read(sizeof(answer)), sizeof(answer));
  if (answer[0] != 0) return false;
  out->rays += answer[1] + answer[2];
  return true;
}

void TraceDevice::upload_scene(const TraceJob& job) {
  const Pose T_proj_cam = job.twin.projector->T_proj_world * job.camera.T_cam_world.inverse();
  const double reach_mm =
      job.scene.far_mm + T_proj_cam.translation_mm.norm() + lens_radius_mm(job.camera.optics);
  upload_meshes(job.scene, reach_mm);
  fill(BIND_LINKS, job.shortcuts.links);
  fill(BIND_STARTS, job.shortcuts.starts);
  std::vector<gpu::vec4> primitives;
  for (const auto& p : job.scene.primitives) {
    for (const Double4& v : p) primitives.push_back(rounded(v));
    for (const Double4& v : p) primitives.push_back(rest_of(v));
  }
  fill(BIND_PRIMITIVES, primitives);
  std::vector<gpu::vec4> materials = job.scene.materials;
  materials.insert(materials.end(), job.scene.below_surfaces.begin(), job.scene.below_surfaces.end());
  fill(BIND_MATERIALS, materials);
  fill(BIND_LENS_GRID, job.lens.nodes);
  fill(BIND_PROJECTOR_GRID, job.projector.table.nodes);
  fill(BIND_BLOCKS, job.blocks);
  reserve(BIND_STATUS, 3 * sizeof(std::uint32_t));
}

void TraceDevice::upload_samples(const SampleSetup& samples) {
  fill(BIND_SAMPLES, samples.table);
  fill(BIND_SOBOL, samples.sobol);
}

void TraceDevice::upload_pass(const TraceJob& job, const PassPlan& pass, const SampleSetup& samples,
                              const AdaptiveTargets& targets) {
  std::vector<float> waveforms = pass.gaps;
  for (const DirectSlot& d : pass.direct)
    waveforms.insert(waveforms.end(), d.waveform.begin(), d.waveform.end());
  waveforms.insert(waveforms.end(), job.scene.maps.begin(), job.scene.maps.end());
  fill(BIND_WAVEFORMS, waveforms);
  ParamsBlock block = make_params(job, samples, pass);
  set_adaptive(job, targets, &block);
  block.values.starts = {job.shortcuts.tile_shift, job.shortcuts.tiles_x, job.shortcuts.tiles, 0};
  reserve(BIND_PARAMS, sizeof(ParamsBlock)).upload(bytes_of(block));
}

}  // namespace fringetwin::render
