// SPDX-License-Identifier: Apache-2.0
#include "render/trace/fixed_trace.hpp"

#include <algorithm>
#include <memory>

#include "render/base/pixel_list.hpp"
#include "render/trace/pixel_blocks.hpp"
#include "render/trace/sample_portions.hpp"
#include "render/trace/sum_targets.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::render {
namespace {

constexpr std::uint32_t kMeshChunk = 64, kAnalyticChunk = 4096;  // samples per dispatch
constexpr std::uint64_t kSamplesPerDispatch = 4U << 20;          // over all pixels: a fraction of a second
constexpr std::uint64_t kSamplesWorthAProgressBar = 400U << 20;

// Writes the objects that the centre rays of a band of blocks saw into the object image.
void scatter_objects(TraceDevice& device, const TraceJob& job, std::size_t first, std::size_t n) {
  const auto* primitives = device.read<std::int32_t>(BIND_OBJECTS, n * BLOCK_PIXELS);
  const int width = job.out->object.width, height = job.out->object.height;
  for (std::size_t b = 0; b < n; ++b) {
    const auto [x0, y0] = corner_of(job.blocks[first + b]);
    for (int y = 0; y < BLOCK_HEIGHT && y0 + y < height; ++y)
      for (int x = 0; x < BLOCK_WIDTH && x0 + x < width; ++x) {
        const std::int32_t p = primitives[b * BLOCK_PIXELS + static_cast<std::size_t>(y * BLOCK_WIDTH + x)];
        job.out->object(x0 + x, y0 + y) = p < 0 ? -1 : job.scene.object_of_primitive[p];
      }
  }
}

// Returns the number of blocks that one dispatch takes: bounded by its time and by the memory of its sums.
std::size_t blocks_per_band(const PassPlan& pass, std::uint32_t samples) {
  const std::uint64_t by_time = kSamplesPerDispatch / (BLOCK_PIXELS * std::uint64_t{samples});
  const std::uint64_t by_memory = kMostOutputBytes / (pass.channels() * BLOCK_PIXELS * sizeof(float));
  return std::max<std::size_t>(16, std::min({by_time, by_memory, std::uint64_t{16384}}));
}

// Traces one pass band by band. `chunk`: samples per dispatch, fewer from now on where the driver cuts loops.
void run_pass(TraceDevice& device, const TraceJob& job, const PassPlan& pass, bool first_pass,
              const SampleSetup& samples, std::uint32_t* chunk, Progress* progress) {
  device.upload_pass(job, pass, samples, {});
  const std::size_t band = blocks_per_band(pass, std::min(*chunk, samples.n));
  const std::size_t most = std::min(band, job.blocks.size());
  device.reserve(BIND_OUTPUT, most * pass.channels() * BLOCK_PIXELS * sizeof(float));
  device.reserve(BIND_OBJECTS, most * BLOCK_PIXELS * sizeof(std::int32_t));
  ComputePipeline& kernel = device.bound_kernel(Kernel::trace, make_constants(job, samples, pass));
  for (std::size_t first = 0; first < job.blocks.size(); first += band) {
    const std::size_t n = std::min(band, job.blocks.size() - first);
    gpu::Push push{};
    push.first_block = static_cast<gpu::uint>(first);
    push.n_blocks_band = static_cast<gpu::uint>(n);
    push.n_centre = first_pass ? 1 : 0;
    push.sentinel = SENTINEL_LOOPS;
    run_in_portions(device, kernel, push, samples.n, static_cast<std::uint32_t>(n), chunk, job.out);
    const auto targets = sum_targets(job.twin, pass, first_pass, job.out);
    scatter_sums(job, targets, first, n, device.read<float>(BIND_OUTPUT, targets.size() * n * BLOCK_PIXELS));
    if (first_pass) scatter_objects(device, job, first, n);
    if (progress) progress->advance(n);
  }
}

// Traces the pixels whose harmonics cannot be formed from their fundamental, with a pair for each.
void run_own_harmonics(TraceDevice& device, const TraceJob& job, const SampleSetup& samples,
                       std::uint32_t* chunk) {
  const Sensor& sensor = job.camera.sensor;
  const FormedLimits limits{0.5 * job.out->sampling.gray_error * sensor.max_dn() / sensor.gain_dn,
                            0.5 * job.out->sampling.phase_error_rad, job.twin.sampled_side_px(job.camera)};
  std::vector<std::vector<FormedError>> found(job.blocks.size());
#pragma omp parallel for schedule(dynamic, 16)
  for (std::size_t b = 0; b < job.blocks.size(); ++b) {
    const auto [x0, y0] = corner_of(job.blocks[b]);
    find_unformed(*job.out, job.harmonics, {}, x0, y0, limits, &found[b]);
  }
  std::vector<std::uint32_t> places, codes;
  for (const auto& f : found)
    for (const FormedError& e : f) places.push_back(e.place);
  for (const std::uint32_t place : places) codes.push_back(list_code_at(place, job.out->mean.width));
  for (const PassPlan& pass : job.harmonics.own) {
    device.upload_pass(job, pass, samples, {});
    const std::size_t band =
        std::min(blocks_per_band(pass, std::min(*chunk, samples.n)) * BLOCK_PIXELS, kLongestList);
    const std::size_t most = std::min(band, codes.size() + BLOCK_PIXELS);
    device.reserve(BIND_OUTPUT, most * pass.channels() * sizeof(float));
    device.reserve(BIND_OBJECTS, most * sizeof(std::int32_t));
    SpecConstants constants = make_constants(job, samples, pass);
    constants[SPEC_PIXEL_LIST] = PIXELS_LISTED;
    const auto targets = sum_targets(job.twin, pass, false, job.out);
    for (std::size_t first = 0; first < codes.size(); first += band) {
      const std::size_t n = std::min(band, codes.size() - first);
      const std::size_t groups = (n + BLOCK_PIXELS - 1) / BLOCK_PIXELS, stride = groups * BLOCK_PIXELS;
      device.fill(BIND_PIXELS,
                  std::vector<std::uint32_t>(codes.begin() + static_cast<std::ptrdiff_t>(first),
                                             codes.begin() + static_cast<std::ptrdiff_t>(first + n)));
      ComputePipeline& kernel = device.bound_kernel(Kernel::trace, constants);
      gpu::Push push{};
      push.n_blocks_band = static_cast<gpu::uint>(groups);
      push.sentinel = SENTINEL_LOOPS;
      push.n_pixels = static_cast<gpu::uint>(n);
      run_in_portions(device, kernel, push, samples.n, static_cast<std::uint32_t>(groups), chunk, job.out);
      const float* sums = device.read<float>(BIND_OUTPUT, pass.channels() * stride);
      for (std::size_t i = 0; i < n; ++i)
        keep_harmonics(pass, places[first + i], job.out,
                       [&](std::size_t c) { return sums[c * stride + i] * targets[c].factor; });
    }
  }
  job.out->rays += std::uint64_t{samples.n} * job.harmonics.own.size() * codes.size();
}

}  // namespace

void trace_by_fixed_rule(TraceDevice& device, const TraceJob& job, const std::vector<PassPlan>& passes) {
  const SampleSetup samples = setup_samples(job.twin, job.camera, job.scene, job.out->sampling);
  const std::uint64_t work = std::uint64_t{samples.n} * BLOCK_PIXELS * job.blocks.size() * passes.size();
  std::unique_ptr<Progress> progress;
  if (work > kSamplesWorthAProgressBar)
    progress = std::make_unique<Progress>("rendering " + job.camera.name, job.blocks.size() * passes.size());
  device.upload_samples(samples);
  std::uint32_t chunk = job.tuning.samples_per_dispatch    ? job.tuning.samples_per_dispatch
                        : job.scene.count[KIND_MESHES] > 0 ? kMeshChunk
                                                           : kAnalyticChunk;
  for (std::size_t i = 0; i < passes.size(); ++i)
    run_pass(device, job, passes[i], i == 0, samples, &chunk, progress.get());
  if (job.harmonics.formed()) run_own_harmonics(device, job, samples, &chunk);
  const int width = job.out->mean.width, height = job.out->mean.height;
  for (const std::uint32_t block : job.blocks) {
    const auto [x, y] = corner_of(block);
    job.out->rays +=
        std::uint64_t{samples.n} * passes.size() *
        static_cast<std::uint64_t>(std::min(BLOCK_WIDTH, width - x) * std::min(BLOCK_HEIGHT, height - y));
  }
}

}  // namespace fringetwin::render
