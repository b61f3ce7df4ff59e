// SPDX-License-Identifier: Apache-2.0
#include "render/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>

#include "loop_limit_spv.h"
#include "render/base/disk_cache.hpp"
#include "render/base/kernels.hpp"
#include "render/base/specialise.hpp"
#include "render/pattern/transport_images.hpp"
#include "render/pattern/waveform.hpp"
#include "render/trace/trace_device.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::render {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

constexpr std::uint32_t mesh_chunk = 64, analytic_chunk = 4096;  // samples per dispatch
constexpr std::uint64_t samples_per_dispatch = 4U << 20;         // over all pixels: a fraction of a second
constexpr std::size_t output_bytes = 64U << 20;
// With more than these, links between triangles are not worth while: rays search; facets are clipped, some
// hundred in a pixel.
constexpr std::size_t triangles_per_traced_pixel = 2, triangles_per_clipped_pixel = 512;
constexpr std::uint64_t samples_worth_a_progress_bar = 400U << 20;

constexpr VkDescriptorType uniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
constexpr VkDescriptorType texels = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
constexpr VkDescriptorType storage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

struct BindingInfo {
  VkDescriptorType type;
  VkFormat format;
};
constexpr std::array<BindingInfo, BIND_COUNT> bindings{{
    {uniform, VK_FORMAT_UNDEFINED},           // params
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // primitives
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // materials
    {texels, VK_FORMAT_R32G32B32A32_SINT},    // nodes
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // triangles
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // corners
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // lens grid
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // projector grid
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // samples
    {texels, VK_FORMAT_R32G32B32A32_UINT},    // sobol
    {texels, VK_FORMAT_R32_SFLOAT},           // waveforms
    {texels, VK_FORMAT_R32_UINT},             // blocks
    {storage, VK_FORMAT_UNDEFINED},           // output
    {storage, VK_FORMAT_UNDEFINED},           // objects
    {storage, VK_FORMAT_UNDEFINED},           // status
    {texels, VK_FORMAT_R32_UINT},             // pixels
    {texels, VK_FORMAT_R32G32B32A32_SFLOAT},  // probe, read
    {storage, VK_FORMAT_UNDEFINED},           // probe, written: the same memory
    {texels, VK_FORMAT_R32G32B32A32_SINT},    // links
    {texels, VK_FORMAT_R32_SINT},             // starts
}};

std::size_t texel_bytes(VkFormat format) {
  return format == VK_FORMAT_R32_SFLOAT || format == VK_FORMAT_R32_UINT || format == VK_FORMAT_R32_SINT ? 4
                                                                                                        : 16;
}

bool is_geometry(std::size_t binding) {
  return (binding >= BIND_NODES && binding <= BIND_CORNERS) || binding == BIND_LINKS;
}

bool same_lens(const Lens& a, const Lens& b) {
  return a.model() == b.model() && a.intrinsics() == b.intrinsics() && a.width() == b.width() &&
         a.height() == b.height();
}

// In any thread.
std::unique_ptr<ComputePipeline> make_kernel(VulkanDevice& device, VkPipelineCache cache,
                                             const KernelStore::Key& key) {
  const auto& [kernel, storage_geometry, precise, constants] = key;
  std::vector<VkDescriptorType> types;
  for (std::size_t i = 0; i < bindings.size(); ++i)
    types.push_back(is_geometry(i) && storage_geometry ? storage : bindings[i].type);
  const std::span<const std::uint32_t> code = kernel_code(kernel, storage_geometry, precise);
  const std::vector<std::uint32_t> own = specialised(code, constants, cache_folder());
  constexpr auto push_bytes = static_cast<std::uint32_t>(sizeof(gpu::Push));
  if (!own.empty())
    return std::make_unique<ComputePipeline>(device, own, types, std::vector<std::uint32_t>{}, push_bytes,
                                             cache);
  return std::make_unique<ComputePipeline>(
      device, code, types, std::vector<std::uint32_t>(constants.begin(), constants.end()), push_bytes, cache);
}

}  // namespace

Renderer::Impl::Impl(const std::string& wanted)
    : device(wanted),
      kernels([this](const KernelStore::Key& key) { return make_kernel(device, cache, key); }) {
  if (device.limits().maxComputeWorkGroupInvocations < BLOCK_PIXELS)
    throw UserError(ExitCode::device, device.info().name,
                    fmt::format("its work groups hold {} invocations, the renderer needs {}",
                                device.limits().maxComputeWorkGroupInvocations, BLOCK_PIXELS));
  VkPipelineCacheCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  vk_check(vkCreatePipelineCache(device.handle(), &create, nullptr, &cache), "vkCreatePipelineCache");
}

Renderer::Impl::~Impl() {
  kernels.clear();
  vkDestroyPipelineCache(device.handle(), cache, nullptr);
}

const LensTable& Renderer::Impl::lens_table(const Lens& lens) {
  for (const auto& [known, table] : lens_tables)
    if (same_lens(known, lens)) return *table;
  lens_tables.emplace_back(lens, std::make_unique<LensTable>(make_lens_table(lens)));
  return *lens_tables.back().second;
}

Buffer& Renderer::Impl::reserve(std::size_t binding, std::size_t bytes) {
  auto& slot = buffers[binding];
  if (slot && slot->bytes() >= bytes) return *slot;
  const bool as_storage = bindings[binding].type == storage || (is_geometry(binding) && storage_geometry);
  const bool as_uniform = bindings[binding].type == uniform;
  VkBufferUsageFlags usage = as_storage   ? VK_BUFFER_USAGE_STORAGE_BUFFER_BIT
                             : as_uniform ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT
                                          : VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  if (binding == BIND_PROBE) usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const VkFormat format = as_storage || as_uniform ? VK_FORMAT_UNDEFINED : bindings[binding].format;
  if (format != VK_FORMAT_UNDEFINED && bytes / texel_bytes(format) > device.limits().maxTexelBufferElements)
    throw UserError(ExitCode::device, device.info().name,
                    fmt::format("a table of {} elements exceeds its texel buffers ({})",
                                bytes / texel_bytes(format), device.limits().maxTexelBufferElements),
                    "use the CPU device");
  slot.reset();
  slot = std::make_unique<Buffer>(device, bytes, usage, format);
  return *slot;
}

// Nodes and triangles of all meshes, one after the other. Boxes grow by the rounding of the slab test
// for rays that come from `reach_mm` away.
void Renderer::Impl::upload_geometry(const PackedScene& scene, const Shortcuts& shortcuts, double reach_mm) {
  const auto pad = static_cast<float>(1e-6 * reach_mm);
  std::vector<BvhNode> nodes;
  std::vector<gpu::vec4> triangles, corners;
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
  const std::size_t largest = std::max(4 * nodes.size(), triangles.size());
  // FRINGETWIN_GEOMETRY=storage forces the variant for small devices, for tests.
  const char* forced = std::getenv("FRINGETWIN_GEOMETRY");
  const bool needs_storage =
      largest > device.limits().maxTexelBufferElements || (forced && std::string(forced) == "storage");
  if (needs_storage != storage_geometry) {
    storage_geometry = needs_storage;
    for (const std::size_t b : {BIND_NODES, BIND_TRIANGLES, BIND_CORNERS, BIND_LINKS}) buffers[b].reset();
  }
  fill(BIND_NODES, nodes);
  fill(BIND_TRIANGLES, triangles);
  fill(BIND_CORNERS, corners);
  fill(BIND_LINKS, shortcuts.links);
  fill(BIND_STARTS, shortcuts.starts);
}

ComputePipeline& Renderer::Impl::bound_kernel(Kernel kernel, const SpecConstants& constants) {
  ComputePipeline& made = kernels.get(kernel_key(kernel, constants));
  // Kernels that use no list or no probe get something to bind all the same.
  for (const std::size_t b : {BIND_PIXELS, BIND_PROBE})
    if (!buffers[b]) reserve(b, 16);
  std::vector<const Buffer*> bound;
  for (std::size_t b = 0; b < BIND_COUNT; ++b)
    bound.push_back(b == BIND_PROBE_OUT ? buffers[BIND_PROBE].get() : buffers[b].get());
  made.bind(bound);
  return made;
}

bool Renderer::Impl::dispatch(ComputePipeline& kernel, const gpu::Push& push, std::uint32_t groups,
                              Transport* out) {
  throw_if_cancelled();
  Buffer& status = *buffers[BIND_STATUS];
  status.upload(std::vector<std::uint32_t>{0, 0, 0});
  kernel.dispatch(groups, bytes_of(push));
  std::array<std::uint32_t, 3> answer{};
  std::memcpy(answer.data(), status.read(sizeof(answer)), sizeof(answer));
  if (answer[0] != 0) return false;
  out->rays += answer[1] + answer[2];
  return true;
}

// All samples of one band of blocks, in chunks that stay below the device's loop limit.
void Renderer::Impl::run_band(ComputePipeline& kernel, gpu::Push push, std::uint32_t n_samples,
                              std::uint32_t groups, std::uint32_t* chunk, Transport* out) {
  const gpu::uint n_centre = push.n_centre;
  const std::uint64_t rays_before = out->rays;
  for (std::uint32_t first = 0; first < n_samples;) {
    push.first_sample = first;
    push.end_sample = std::min(n_samples, first + *chunk);
    push.resume = first > 0;
    push.n_centre = first == 0 ? n_centre : 0;
    if (dispatch(kernel, push, groups, out)) {
      first = push.end_sample;
      continue;
    }
    // Some invocation was cut short: its sums are wrong. Again from the start, in smaller portions.
    if (*chunk == 1)
      throw UserError(ExitCode::device, device.info().name,
                      "a single ray exceeds the driver's limit of loop iterations",
                      "use a newer driver (Mesa 25 has no such limit) or split the mesh");
    *chunk = std::max(1U, std::min(*chunk, n_samples) / 2);
    ++repeated;
    out->rays = rays_before;
    first = 0;
  }
}

std::vector<SumTarget> sum_targets(const Twin& twin, const PassPlan& pass, bool first_pass, Transport* out) {
  std::vector<SumTarget> targets{
      {first_pass ? &out->mean : nullptr, 1.0F},
      {first_pass ? &out->ambient : nullptr, static_cast<float>(twin.projector->ambient)}};
  for (const PitchSlot& p : pass.pitches) {
    const double pitch_px = twin.fringes.directions[p.direction].pitches_px[p.pitch];
    const auto blur = static_cast<float>(blur_attenuation(p.harmonic, twin.projector->blur_px, pitch_px));
    const PairImages images = pair_images(out, p);
    targets.push_back({images.cosine, blur});
    targets.push_back({images.sine, blur});
  }
  for (const DirectSlot& d : pass.direct) targets.push_back({&out->direct[d.image], 1.0F});
  return targets;
}

void Renderer::Impl::scatter_sums(const TraceJob& job, const std::vector<SumTarget>& targets,
                                  std::size_t first, std::size_t n, const float* sums) {
  const std::size_t stride = n * BLOCK_PIXELS;
  const int width = job.out->mean.width, height = job.out->mean.height;
#pragma omp parallel for
  for (std::ptrdiff_t b = 0; b < static_cast<std::ptrdiff_t>(n); ++b) {
    const std::uint32_t block = job.blocks[first + static_cast<std::size_t>(b)];
    const int x0 = static_cast<int>(block & 0xffffU) * BLOCK_WIDTH,
              y0 = static_cast<int>(block >> 16) * BLOCK_HEIGHT;
    const int columns = std::min(BLOCK_WIDTH, width - x0);
    for (int y = 0; y < BLOCK_HEIGHT && y0 + y < height; ++y) {
      const std::size_t slot =
          static_cast<std::size_t>(b) * BLOCK_PIXELS + static_cast<std::size_t>(y * BLOCK_WIDTH);
      for (std::size_t c = 0; c < targets.size(); ++c) {
        if (!targets[c].image) continue;
        const float* from = sums + c * stride + slot;
        float* to = &(*targets[c].image)(x0, y0 + y);
        for (int x = 0; x < columns; ++x) to[x] = from[x] * targets[c].factor;
      }
    }
  }
}

void Renderer::Impl::scatter_objects(const TraceJob& job, std::size_t first, std::size_t n) {
  const auto* primitives = reinterpret_cast<const std::int32_t*>(
      buffers[BIND_OBJECTS]->read(n * BLOCK_PIXELS * sizeof(std::int32_t)));
  const int width = job.out->object.width, height = job.out->object.height;
  for (std::size_t b = 0; b < n; ++b) {
    const std::uint32_t block = job.blocks[first + b];
    const int x0 = static_cast<int>(block & 0xffffU) * BLOCK_WIDTH,
              y0 = static_cast<int>(block >> 16) * BLOCK_HEIGHT;
    for (int y = 0; y < BLOCK_HEIGHT && y0 + y < height; ++y)
      for (int x = 0; x < BLOCK_WIDTH && x0 + x < width; ++x) {
        const std::int32_t p = primitives[b * BLOCK_PIXELS + static_cast<std::size_t>(y * BLOCK_WIDTH + x)];
        job.out->object(x0 + x, y0 + y) =
            p < 0 ? -1 : job.scene.object_of_primitive[static_cast<std::size_t>(p)];
      }
  }
}

// The same samples in every pixel of the blocks.
void Renderer::Impl::trace_plain(const TraceJob& job, const std::vector<PassPlan>& passes,
                                 const SampleSetup& samples) {
  upload_samples(samples);
  std::uint32_t chunk = forced_chunk ? forced_chunk : job.scene.n_meshes > 0 ? mesh_chunk : analytic_chunk;
  for (std::size_t i = 0; i < passes.size(); ++i) {
    const PassPlan& pass = passes[i];
    upload_pass(job, pass, samples, {});
    const std::uint64_t by_time =
        samples_per_dispatch / (BLOCK_PIXELS * std::uint64_t{std::min(chunk, samples.n)});
    const std::uint64_t by_memory = output_bytes / (pass.channels() * BLOCK_PIXELS * sizeof(float));
    const std::size_t band = std::max<std::size_t>(16, std::min({by_time, by_memory, std::uint64_t{16384}}));
    const std::size_t most = std::min(band, job.blocks.size());
    reserve(BIND_OUTPUT, most * pass.channels() * BLOCK_PIXELS * sizeof(float));
    reserve(BIND_OBJECTS, most * BLOCK_PIXELS * sizeof(std::int32_t));
    ComputePipeline& kernel =
        bound_kernel(Kernel::trace, make_constants(job.twin, job.camera, job.scene, job.lens, job.projector,
                                                   samples, pass, job.shortcuts.kinds));
    for (std::size_t first = 0; first < job.blocks.size(); first += band) {
      const std::size_t n = std::min(band, job.blocks.size() - first);
      gpu::Push push{};
      push.first_block = static_cast<gpu::uint>(first);
      push.n_blocks_band = static_cast<gpu::uint>(n);
      push.n_centre = i == 0 ? 1 : 0;
      push.sentinel = SENTINEL_LOOPS;
      run_band(kernel, push, samples.n, static_cast<std::uint32_t>(n), &chunk, job.out);
      const auto targets = sum_targets(job.twin, pass, i == 0, job.out);
      const std::size_t bytes = targets.size() * n * BLOCK_PIXELS * sizeof(float);
      scatter_sums(job, targets, first, n, reinterpret_cast<const float*>(buffers[BIND_OUTPUT]->read(bytes)));
      if (i == 0) scatter_objects(job, first, n);
      if (job.progress) job.progress->advance(n);
    }
  }
  const int width = job.out->mean.width, height = job.out->mean.height;
  for (const std::uint32_t block : job.blocks) {
    const int x = static_cast<int>(block & 0xffffU) * BLOCK_WIDTH,
              y = static_cast<int>(block >> 16) * BLOCK_HEIGHT;
    job.out->rays +=
        std::uint64_t{samples.n} * passes.size() *
        static_cast<std::uint64_t>(std::min(BLOCK_WIDTH, width - x) * std::min(BLOCK_HEIGHT, height - y));
  }
}

void Renderer::Impl::upload_scene(const TraceJob& job) {
  const Pose T_proj_cam = job.twin.projector->T_proj_world * job.camera.T_cam_world.inverse();
  const double reach_mm = job.scene.far_mm + T_proj_cam.translation_mm.norm() + lens_radius_mm(job.camera);
  upload_geometry(job.scene, job.shortcuts, reach_mm);
  std::vector<gpu::vec4> primitives;
  for (const auto& p : job.scene.primitives) {
    for (const Double4& v : p) primitives.push_back(rounded(v));
    for (const Double4& v : p) primitives.push_back(rest_of(v));
  }
  fill(BIND_PRIMITIVES, primitives);
  fill(BIND_MATERIALS, job.scene.materials);
  fill(BIND_LENS_GRID, job.lens.nodes);
  fill(BIND_PROJECTOR_GRID, job.projector.table.nodes);
  fill(BIND_BLOCKS, job.blocks);
  reserve(BIND_STATUS, 3 * sizeof(std::uint32_t));
}

void Renderer::Impl::upload_samples(const SampleSetup& samples) {
  fill(BIND_SAMPLES, samples.table);
  fill(BIND_SOBOL, samples.sobol);
}

void Renderer::Impl::upload_pass(const TraceJob& job, const PassPlan& pass, const SampleSetup& samples,
                                 const AdaptiveTargets& targets) {
  std::vector<float> waveforms = pass.gaps;
  for (const DirectSlot& d : pass.direct)
    waveforms.insert(waveforms.end(), d.waveform.begin(), d.waveform.end());
  waveforms.insert(waveforms.end(), job.scene.maps.begin(), job.scene.maps.end());
  fill(BIND_WAVEFORMS, waveforms);
  ParamsBlock block =
      make_params(job.twin, job.camera, job.scene, job.lens, job.projector, samples, pass, job.seed);
  set_adaptive(job.twin, job.camera, targets, &block);
  block.values.starts = {job.shortcuts.tile_shift, job.shortcuts.tiles_x, job.shortcuts.tiles, 0};
  reserve(BIND_PARAMS, sizeof(ParamsBlock)).upload(bytes_of(block));
}

Renderer::Renderer(const std::string& device) : impl_(std::make_unique<Impl>(device)) {}
Renderer::~Renderer() = default;
const DeviceInfo& Renderer::device() const { return impl_->device.info(); }
int Renderer::validation_messages() const { return impl_->device.instance().validation_messages(); }
void Renderer::set_samples_per_dispatch(std::uint32_t samples) { impl_->forced_chunk = samples; }
void Renderer::set_line_stretches(std::uint32_t stretches) { impl_->line_stretches = stretches; }
void Renderer::set_search_always(bool always) { impl_->search_always = always; }
void Renderer::set_pattern_method(PatternMethod method) { impl_->pattern_method = method; }
int Renderer::repeated_dispatches() const { return impl_->repeated; }

std::uint32_t Renderer::count_loop_iterations(std::uint32_t requested) {
  ComputePipeline kernel(impl_->device, loop_limit_spv, {storage}, {}, sizeof(gpu::Push), impl_->cache);
  Buffer status(impl_->device, sizeof(std::uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  kernel.bind({&status});
  gpu::Push push{};
  push.end_sample = requested;
  kernel.dispatch(1, bytes_of(push));
  std::uint32_t count = 0;
  std::memcpy(&count, status.read(sizeof(count)), sizeof(count));
  return count;
}

Transport Renderer::trace(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                          std::uint64_t seed) {
  const auto start = Clock::now();
  FT_CHECK(camera_index < twin.cameras.size(), "camera index");
  if (!twin.projector)
    throw UserError(ExitCode::usage, twin.file.string(),
                    "the twin has no projector, so nothing lights the scene", "add a [projector] section");
  check_sampling(sampling, twin.render.pixel_fill);

  impl_->precise = sampling.precise;
  if (impl_->precise && !impl_->device.has_double()) {
    warn(fmt::format(
        "{} has no double precision: rounding leaves up to {:.1e} rad of phase error, {} asked for",
        impl_->device.info().name, single_precision_error_rad(twin), sampling.phase_error_rad));
    impl_->precise = false;
  }
  const Camera& camera = twin.cameras[camera_index];
  const PackedScene scene = pack_scene(twin, camera, impl_->meshes);
  const LensTable& lens = impl_->lens_table(camera.lens);
  const ProjectorSetup projector = setup_projector(*twin.projector);
  const std::vector<std::uint32_t> blocks = active_blocks(camera, scene, lens);
  const SeriesTable series = choose_series(twin, impl_->pattern_method, sampling.phase_error_rad);
  const std::vector<PassPlan> passes = plan_passes(twin, series, projector.cx, projector.cy);

  Transport out = empty_transport(twin, passes, series, camera.lens.width(), camera.lens.height());
  bool adaptive = sampling.sampler == Sampler::adaptive &&
                  can_trace_adaptively(twin, camera, scene, passes, impl_->device.limits());
  const std::size_t per_pixel = adaptive ? triangles_per_clipped_pixel : triangles_per_traced_pixel;
  const Shortcuts shortcuts =
      impl_->search_always
          ? Shortcuts{}
          : make_shortcuts(twin, camera, scene, per_pixel * blocks.size() * BLOCK_PIXELS, impl_->visibility);
  TraceJob job{twin, camera, scene, lens, projector, blocks, shortcuts, seed, nullptr, &out};
  out.sampling = adaptive ? sampling : without_adaptation(sampling, twin, camera);
  if (!blocks.empty()) {
    impl_->upload_scene(job);
    if (adaptive) {
      try {
        trace_adaptively(*impl_, job, passes, sampling);
      } catch (const LoopLimit&) {
        warn(fmt::format(
            "{}: the driver's limit of loop iterations stops the adaptive trace; a fixed rule of {} "
            "samples is used (Mesa 25 has no such limit: make mesa25)",
            camera.name, without_adaptation(sampling, twin, camera).samples));
        adaptive = false;
        out = empty_transport(twin, passes, series, camera.lens.width(), camera.lens.height());
        out.sampling = without_adaptation(sampling, twin, camera);
      }
    }
    std::unique_ptr<Progress> progress;
    if (!adaptive) {
      const SampleSetup samples = setup_samples(twin, camera, scene, out.sampling);
      const std::uint64_t work = std::uint64_t{samples.n} * BLOCK_PIXELS * blocks.size() * passes.size();
      if (work > samples_worth_a_progress_bar)
        progress = std::make_unique<Progress>("rendering " + camera.name, blocks.size() * passes.size());
      job.progress = progress.get();
      impl_->trace_plain(job, passes, samples);
    }
  }
  impl_->kernels.stop_soon();
  out.sampling.precise = impl_->precise;
  out.trace_ms = ms_since(start);
  return out;
}

RenderedCamera Renderer::render(const Twin& twin, std::size_t camera_index, const Sampling& sampling,
                                std::uint64_t seed, bool references) {
  const auto start = Clock::now();
  const Transport transport = trace(twin, camera_index, sampling, seed);
  RenderedCamera out = form_camera(twin, camera_index, transport, references);
  out.total_ms = ms_since(start);
  return out;
}

}  // namespace fringetwin::render
