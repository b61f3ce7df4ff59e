// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/gatherer.hpp"

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t kMostPoints = 4096, kMostBytes = 64U << 20;
// Of a point in one dispatch, so that walks through a mesh stay below the driver's loop limit.
constexpr std::uint32_t kDirectionsAtATime = 32;

TraceJob without_cells(TraceJob job) {
  job.cells = nullptr;
  return job;
}

}  // namespace

Gatherer::Gatherer(TraceDevice& device, const TraceJob& job, const PassPlan& pass, const SampleSetup& samples)
    : device_(device),
      job_(without_cells(job)),
      pass_(pass),
      constants_(make_constants(job_, samples, pass)),
      directions_(constants_[SPEC_BOUNCES]),
      most_(std::clamp(kMostBytes / (sizeof(SurfacePlace) * (directions_ + 1)) / BLOCK_PIXELS * BLOCK_PIXELS,
                       std::size_t{BLOCK_PIXELS}, kMostPoints)) {
  device_.upload_pass(job_, pass, samples, {});
  device_.reserve(BIND_OUTPUT, most_ * pass.channels() * sizeof(float));
  device_.reserve(BIND_HITS, most_ * (directions_ + 1) * sizeof(SurfacePlace));
}

Gathered Gatherer::of_pixels(const std::vector<std::uint32_t>& codes) {
  FT_CHECK(!codes.empty() && codes.size() <= most_, "as many pixels as gather at a time");
  device_.fill(BIND_PIXELS, codes);
  return run(codes.size(), codes.size());
}

Gathered Gatherer::of_points(std::span<const SurfacePlace> points) {
  FT_CHECK(!points.empty() && points.size() <= most_, "as many points as gather at a time");
  std::vector<SurfacePlace> padded(points.begin(), points.end());
  padded.resize((points.size() + BLOCK_PIXELS - 1) / BLOCK_PIXELS * BLOCK_PIXELS, points.back());
  device_.fill(BIND_POINTS, padded);
  return run(points.size(), 0);
}

Gathered Gatherer::run(std::size_t n, std::size_t n_pixels) {
  const std::size_t groups = (n + BLOCK_PIXELS - 1) / BLOCK_PIXELS, stride = groups * BLOCK_PIXELS;
  ComputePipeline& kernel = device_.bound_kernel(Kernel::gather, constants_);
  gpu::Push push{};
  push.n_blocks_band = static_cast<gpu::uint>(groups);
  push.sentinel = SENTINEL_LOOPS;
  push.n_pixels = static_cast<gpu::uint>(n_pixels);
  const auto all = static_cast<std::uint32_t>(directions_);
  std::uint32_t at_a_time = std::min(kDirectionsAtATime, all);
  for (std::uint32_t first = 0; first < all;) {
    push.first_sample = first;
    push.end_sample = std::min(all, first + at_a_time);
    push.resume = first > 0;
    if (device_.dispatch(kernel, push, static_cast<std::uint32_t>(groups), job_.out)) {
      first = push.end_sample;
      job_.out->rays += n * (push.end_sample - push.first_sample);
      continue;
    }
    if (at_a_time == 1)
      throw UserError(ExitCode::device, device_.vulkan().info().name,
                      "a single ray exceeds the driver's limit of loop iterations",
                      "use a newer driver (Mesa 25 has no such limit) or split the mesh");
    at_a_time = std::max(1U, at_a_time / 2);  // sums that were cut short are wrong: from the start
    first = 0;
  }
  return {device_.read<SurfacePlace>(BIND_HITS, stride * (directions_ + 1)),
          device_.read<float>(BIND_OUTPUT, stride * pass_.channels()), n, stride, directions_};
}

}  // namespace fringetwin::render
