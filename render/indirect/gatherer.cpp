// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/gatherer.hpp"

#include <algorithm>

#include "render/base/pixel_list.hpp"
#include "render/trace/sample_portions.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t kMostPlaces = 16384, kMostBytes = 64U << 20;
// Of a place in one dispatch, so that walks through a mesh stay below the driver's loop limit.
constexpr std::uint32_t kDirectionsAtATime = 32;

std::size_t groups_of(std::size_t n) { return (n + BLOCK_PIXELS - 1) / BLOCK_PIXELS; }

// Returns how many directions each way of mirrored light has, beside those of the hemisphere: even, as these.
std::uint32_t of_each_way(std::size_t directions) {
  constexpr std::size_t kOneOf = 8;
  return static_cast<std::uint32_t>(std::max<std::size_t>(2, directions / kOneOf / 2 * 2));
}

// A rule of one ray, for what every kernel wants to know of samples.
const SampleSetup& one_ray() {
  static const SampleSetup samples = [] {
    SampleSetup rule;
    rule.n = 1;
    rule.table = {{0.0F, 0.0F, 1.0F, 0.0F}};
    return rule;
  }();
  return samples;
}

}  // namespace

SeenPlaces look_at(TraceDevice& device, const TraceJob& job, const std::vector<std::uint32_t>& pixels,
                   const Eigen::Vector2d& moved_px) {
  TraceJob moved = job;
  moved.look_px = moved_px;
  moved.cells.reset();
  const PassPlan no_sums;
  const SampleSetup& samples = one_ray();
  device.upload_samples(samples);
  device.upload_pass(moved, no_sums, samples, {});
  SeenPlaces seen;
  for (std::size_t first = 0; first < pixels.size(); first += kLongestList) {
    const std::size_t n = std::min(kLongestList, pixels.size() - first), groups = groups_of(n);
    std::vector<std::uint32_t> codes;
    for (std::size_t i = first; i < first + n; ++i)
      codes.push_back(list_code_at(pixels[i], job.camera.lens.width()));
    device.fill(BIND_PIXELS, codes);
    device.reserve(BIND_PLACES, groups * BLOCK_PIXELS * sizeof(SurfacePlace));
    device.reserve(BIND_OUTPUT, groups * BLOCK_PIXELS * (no_sums.channels() + GATHER_MORE) * sizeof(float));
    gpu::Push push{};
    push.n_blocks_band = static_cast<gpu::uint>(groups);
    push.sentinel = SENTINEL_LOOPS;
    push.n_pixels = static_cast<gpu::uint>(n);
    ComputePipeline& kernel = device.bound_kernel(Kernel::gather, make_constants(moved, samples, no_sums));
    if (!device.dispatch(kernel, push, static_cast<std::uint32_t>(groups), job.out))
      throw_ray_cut_short(device);
    job.out->rays += n;
    const auto* places = device.read<SurfacePlace>(BIND_PLACES, n);
    for (std::size_t i = 0; i < n; ++i) {
      if (!(places[i].primitive >= 0.0F)) continue;
      seen.pixels.push_back(pixels[first + i]);
      seen.places.push_back(places[i]);
    }
  }
  return seen;
}

Gatherer::Gatherer(TraceDevice& device, const TraceJob& job, const PassPlan& pass, std::size_t directions,
                   bool with_places, By by)
    : device_(device),
      job_(job),
      pass_(pass),
      constants_(make_constants(job, one_ray(), pass)),
      directions_(directions),
      most_(kMostPlaces),
      at_a_time_(kDirectionsAtATime) {
  FT_CHECK(directions >= 2 && directions % 2 == 0, "two sets of directions");
  constants_[SPEC_BOUNCES] = 1;
  constants_[SPEC_WRITE_PLACES] = with_places ? 1 : 0;
  constants_[SPEC_GLOSSY] = is_glossy(job) ? 1 : 0;
  constants_[SPEC_BY_LOBE] = by == By::lobe ? 1 : 0;
  if (is_glossy(job) && by == By::reflectivity && job.mirrors > 0) {
    of_way_ = of_each_way(directions);
    constants_[SPEC_N_WAYS] = MIRROR_WAYS;
  }
  if (with_places)
    most_ = std::clamp(kMostBytes / (sizeof(SurfacePlace) * directions) / BLOCK_PIXELS * BLOCK_PIXELS,
                       std::size_t{BLOCK_PIXELS}, kMostPlaces);
  device_.upload_samples(one_ray());
  device_.upload_pass(job, pass, one_ray(), {});
  device_.reserve(BIND_OUTPUT, most_ * (pass.channels() + GATHER_MORE) * sizeof(float));
  if (with_places) device_.reserve(BIND_PLACES, most_ * directions * sizeof(SurfacePlace));
}

Gathered Gatherer::gather(std::span<const SurfacePlace> places) {
  FT_CHECK(!places.empty() && places.size() <= most_, "as many places as gather at a time");
  const std::size_t n = places.size(), stride = groups_of(n) * BLOCK_PIXELS;
  std::vector<SurfacePlace> padded(places.begin(), places.end());
  padded.resize(stride, places.back());
  device_.fill(BIND_POINTS, padded);
  gpu::Push push{};
  push.n_blocks_band = static_cast<gpu::uint>(groups_of(n));
  push.sentinel = SENTINEL_LOOPS;
  push.n_directions = static_cast<gpu::uint>(directions_);
  push.n_of_way = of_way_;
  push.n_mirrors = job_.mirrors;
  if (of_way_ > 0) find_mirror_ways(push);
  const std::uint32_t all = push.n_directions + constants_[SPEC_N_WAYS] * of_way_;
  run_in_portions(device_, device_.bound_kernel(Kernel::gather, constants_), push, all, push.n_blocks_band,
                  &at_a_time_, job_.out);
  job_.out->rays += std::uint64_t{n} * all;
  const bool with_places = constants_[SPEC_WRITE_PLACES] != 0;
  return {device_.read<float>(BIND_OUTPUT, stride * (pass_.channels() + GATHER_MORE)),
          with_places ? device_.read<SurfacePlace>(BIND_PLACES, stride * directions_) : nullptr,
          n,
          stride,
          directions_,
          pass_.channels(),
          finest_fringes()};
}

// Returns the channel of the finest fringes of glossy light.
std::optional<std::size_t> Gatherer::finest_fringes() const {
  if (!is_glossy(job_)) return std::nullopt;
  std::optional<std::size_t> finest;
  double per_px = 0.0;
  for (std::size_t i = 0; i < pass_.pitches.size(); ++i)
    if ((pass_.fundamentals() >> i & 1U) != 0 && pass_.pitches[i].values[0] > per_px) {
      per_px = pass_.pitches[i].values[0];
      finest = 2 + 2 * i;
    }
  return finest;
}

// Where the driver's limit of loop iterations cuts it short there are no ways: only noise is larger for it.
void Gatherer::find_mirror_ways(gpu::Push push) {
  const std::size_t texels = std::size_t{push.n_blocks_band} * BLOCK_PIXELS * MIRROR_WAYS * WAY_TEXELS;
  device_.reserve(BIND_WAYS, texels * sizeof(gpu::vec4));
  if (!device_.dispatch(device_.bound_kernel(Kernel::mirror_ways, constants_), push, push.n_blocks_band,
                        job_.out))
    device_.fill(BIND_WAYS, std::vector<gpu::vec4>(texels, gpu::vec4{}));
}

}  // namespace fringetwin::render
