// SPDX-License-Identifier: Apache-2.0
// Runs the kernel that lets places of the surfaces gather light over others (shaders/gather.comp). Internal
// to render/ (includes volk).
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/trace/trace_device.hpp"

namespace fringetwin::render {

/// A place of a surface as the kernel reads and writes it, in the camera's frame.
struct SurfacePlace {
  Eigen::Vector3f p_mm;
  /// Of a place that gathers: the seed of its directions, a whole number below 2^24. Of what a pixel sees:
  /// the projector's light there, below 0 where it sees nothing. Of what a direction met: its reflectivity,
  /// below 0 where that is nothing.
  float number;
  Eigen::Vector3f n;   ///< shading normal
  float reflectivity;  ///< of what a pixel sees
  Eigen::Vector3f n_geometric;
  float primitive;  ///< of what a pixel sees or a direction met, a whole number; -1 none
};
static_assert(sizeof(SurfacePlace) == 48);

/// What a few places gathered; valid until the next ones do.
struct Gathered {
  const float* sums;
  const SurfacePlace* met_places;  ///< nullptr where they were not asked for
  std::size_t n, stride, directions;
  std::span<const SurfacePlace> met(std::size_t point) const {
    return {met_places + point * directions, directions};
  }
  std::size_t channels = 0;  ///< of the pass
  /// Returns a sum of the pass, light per unit of the point's own reflectivity; channel 1 is the mean over
  /// the first half of the directions. Those that a facet cuts off, whose normal is not the shading normal,
  /// count as the others.
  float sum(std::size_t channel, std::size_t point) const {
    return sums[channel * stride + point] / leaving(point);
  }
  /// Returns the standard error of the light: half the difference between the two halves of the directions,
  /// of the mean, and where the light is glossy of the finest fringes, which it is of rather then.
  float sigma(std::size_t point) const {
    const float of_mean = std::abs(2.0F * sum(1, point) - sum(0, point));
    if (!finest_fringes) return of_mean;
    const auto apart = [&](std::size_t k) {
      return 2.0F * sum(channels + 4 + k, point) - sum(*finest_fringes + k, point);
    };
    return std::max(of_mean, std::hypot(apart(0), apart(1)));
  }
  std::optional<std::size_t> finest_fringes = std::nullopt;  ///< channel of their cosine
  /// Returns the share of the directions that leave the surface; 1/4 at least.
  float leaving(std::size_t point) const { return std::max(sums[(channels + 3) * stride + point], 0.25F); }
  /// Returns the vector v for which the mean light of a normal n near the point's own is n.v times its own.
  Eigen::Vector3f towards(std::size_t point, const Eigen::Vector3f& own_normal) const {
    const auto component = [&](std::size_t k) { return sums[(channels + k) * stride + point]; };
    const Eigen::Vector3f from(component(0), component(1), component(2));
    const float along = from.dot(own_normal);
    return along > 0.0F ? Eigen::Vector3f(from / along) : own_normal;
  }
};

/// Returns what the middles of all pixels that may see something see, moved by a part of a pixel: indices of
/// pixels (x + width y) and places, those that see nothing left out. The scene must have been uploaded.
struct SeenPlaces {
  std::vector<std::uint32_t> pixels;
  std::vector<SurfacePlace> places;
};
SeenPlaces look_at(TraceDevice& device, const TraceJob& job, const std::vector<std::uint32_t>& pixels,
                   const Eigen::Vector2d& moved_px = Eigen::Vector2d::Zero());

/// Returns how many values the light of a place has: the sums of a pass without the hits.
inline std::size_t light_channels(const PassPlan& pass) { return pass.channels() - 1; }

/// Returns whether light between surfaces leaves them by their lobes, too.
inline bool is_glossy(const TraceJob& job) {
  return job.twin.render.glossy_bounces && job.scene.specular != 0;
}

class Gatherer {
 public:
  /// What a place does with the light around it: it has a reflectivity for all of it, or its lobe sends a
  /// part to the camera (a sum of light then, and only of places that pixels see).
  enum class By { reflectivity, lobe };

  /// Uploads the pass; the scene must have been uploaded. Light over more than one surface is that of
  /// job.cells. `directions`: of each place, a multiple of 2. `with_places`: what they meet is wanted.
  Gatherer(TraceDevice& device, const TraceJob& job, const PassPlan& pass, std::size_t directions,
           bool with_places, By by = By::reflectivity);
  /// Returns how many places gather at a time.
  std::size_t most_at_a_time() const { return most_; }
  Gathered gather(std::span<const SurfacePlace> places);

 private:
  void find_mirror_ways(gpu::Push push);
  std::optional<std::size_t> finest_fringes() const;

  TraceDevice& device_;
  const TraceJob& job_;
  const PassPlan& pass_;
  SpecConstants constants_;
  std::size_t directions_, most_;
  std::uint32_t of_way_ = 0;  ///< directions besides, along each way of mirrored light
  std::uint32_t at_a_time_;   ///< directions in one dispatch
};

}  // namespace fringetwin::render
