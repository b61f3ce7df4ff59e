// SPDX-License-Identifier: Apache-2.0
// Runs the kernel that lets points of the surfaces gather light over others (shaders/gather.comp). Internal
// to render/ (includes volk).
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/trace/trace_device.hpp"

namespace fringetwin::render {

/// A place of a surface as the kernel reads and writes it, in the camera's frame.
struct SurfacePlace {
  Eigen::Vector3f p_mm;
  /// Of a point that gathers: the seed of its directions, a whole number below 2^24. Of what a pixel sees:
  /// the projector's light there, below 0 where it sees nothing. Of what a direction met: its reflectivity,
  /// below 0 where that is nothing.
  float number;
  Eigen::Vector3f n;  ///< shading normal
  float unused_1;
  Eigen::Vector3f n_geometric;
  float unused_2;
};
static_assert(sizeof(SurfacePlace) == 48);

/// What a few points gathered; valid until the next ones do.
struct Gathered {
  const SurfacePlace* places;
  const float* sums;
  std::size_t n, stride, directions;
  const SurfacePlace& own(std::size_t point) const { return places[point * (directions + 1)]; }
  std::span<const SurfacePlace> met(std::size_t point) const {
    return {places + point * (directions + 1) + 1, directions};
  }
  /// Returns a sum of the pass, light per unit of the point's own reflectivity.
  float sum(std::size_t channel, std::size_t point) const { return sums[channel * stride + point]; }
};

class Gatherer {
 public:
  /// Uploads the pass; the scene must have been uploaded.
  Gatherer(TraceDevice& device, const TraceJob& job, const PassPlan& pass, const SampleSetup& samples);
  /// Returns how many points gather at a time.
  std::size_t most_at_a_time() const { return most_; }
  /// Lets gather what the middles of pixels (x | y << 15) see, or given points.
  Gathered of_pixels(const std::vector<std::uint32_t>& codes);
  Gathered of_points(std::span<const SurfacePlace> points);
  std::size_t directions() const { return directions_; }

 private:
  Gathered run(std::size_t n, std::size_t n_pixels);

  TraceDevice& device_;
  TraceJob job_;
  const PassPlan& pass_;
  SpecConstants constants_;
  std::size_t directions_, most_;
};

}  // namespace fringetwin::render
