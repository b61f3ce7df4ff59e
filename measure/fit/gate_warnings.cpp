// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/gate_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "measure/fit/object_fits.hpp"
#include "twin/base/statistics.hpp"
#include "twin/number/evenly_spread.hpp"

namespace fringetwin::measure {
namespace {

/// Points of a fit that are asked how they lie in its gate: a share of 0.75 is known to 0.025.
constexpr std::size_t kMostAsked = 300;
/// Rays that are followed: with a mesh each takes milliseconds.
constexpr std::size_t kMostGateRays = 2000, kMostRaysAtMeshes = 300, kFewestGateRays = 20;
/// Points among which those near an object are looked for: 300 of an object that has a hundredth of them.
constexpr std::size_t kMostTried = 30'000;
/// Of the points within the gate, in its inner half: of noise about the surface 0.77 and more (a gate of 2.4
/// sigma; 0.87 of 3 sigma), of a surface that passes through the gate 0.5, and less of one that is bent away.
constexpr double kGathered = 0.75;
/// What lies farther from the object than this many gates is another thing, or a plane's continuation.
/// Objects that are displaced by several gates have most of their points nearer.
constexpr double kNearGates = 10.0;
/// Of the object's points within the gate: of fewer no robust fit is told which surface is the object's.
constexpr double kLeastInside = 0.5;
/// Of the points within the gate that lie in its outermost tenth, and of all that lie beyond it. Points that
/// fill the gate evenly have a tenth there; points of a right twin are noise about its middle.
constexpr double kOuterPart = 0.9, kPiledUp = 0.05, kLostBeyond = 0.05;

std::size_t most_rays(const Twin& twin) {
  return std::ranges::any_of(
             twin.objects,
             [](const Object& object) { return std::holds_alternative<MeshShape>(object.shape); })
             ? kMostRaysAtMeshes
             : kMostGateRays;
}

/// Tells which object of the twin a ray meets first, by steps that are as long as the nearest surface is far.
class FirstSurface {
 public:
  explicit FirstSurface(const Twin& twin) {
    for (const Object& object : twin.objects)
      surfaces_.emplace_back(object, std::numeric_limits<double>::infinity());
  }
  /// Returns the object, or how many there are where the ray through the point meets none.
  std::size_t along(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& through_mm) const {
    constexpr int kMostRaySteps = 200;  // a ray that needs more only grazes
    constexpr double kFarthest = 4.0;   // of the point's distance
    constexpr double kTouching = 1e-4;  // of the point's distance: much less than any gate
    const double range_mm = (through_mm - from_mm).norm();
    const Eigen::Vector3d direction = (through_mm - from_mm) / range_mm;
    double at_mm = 0.0;
    for (int step = 0; step < kMostRaySteps && at_mm < kFarthest * range_mm; ++step) {
      double nearest_mm = std::numeric_limits<double>::infinity();
      std::size_t object = surfaces_.size();
      for (std::size_t k = 0; k < surfaces_.size(); ++k)
        if (const double d_mm = surfaces_[k].distance_mm(from_mm + at_mm * direction); d_mm < nearest_mm)
          nearest_mm = d_mm, object = k;
      if (nearest_mm < kTouching * range_mm) return object;
      at_mm += nearest_mm;
    }
    return surfaces_.size();
  }

 private:
  std::vector<SurfaceGate> surfaces_;
};

/// Holds the distances of points to the surface that the camera should see where it sees them.
struct SeenPoints {
  std::vector<double> distance_mm;
  double of_cloud_per_point = 0.0;  ///< how many points of the cloud each of them stands for
};

/// Holds a point of the cloud near an object.
struct NearPoint {
  std::size_t index;
  double distance_mm;
};

/// Returns points near an object, out of those with the indices.
std::vector<NearPoint> near_points(const Object& object, double limit_mm, const PointCloud& cloud,
                                   const std::vector<std::size_t>& tried) {
  const SurfaceGate surface(object, limit_mm);
  std::vector<double> distance_mm(tried.size());
#pragma omp parallel for schedule(dynamic, 64)
  for (std::size_t k = 0; k < tried.size(); ++k)
    distance_mm[k] = surface.distance_mm(cloud.p_world_mm[tried[k]]);
  std::vector<NearPoint> near;
  for (std::size_t k = 0; k < tried.size(); ++k)
    if (std::isfinite(distance_mm[k])) near.push_back({tried[k], distance_mm[k]});
  return near;
}

/// Returns those of points near an object whose rays meet it before any other of the twin.
SeenPoints seen_points_near(const Twin& twin, const Object& object, double gate_mm, const PointCloud& cloud) {
  const std::vector<std::size_t> tried = evenly_spread(cloud.size(), kMostTried);
  const std::vector<NearPoint> near = near_points(object, kNearGates * gate_mm, cloud, tried);
  const std::vector<std::size_t> rays = evenly_spread(near.size(), most_rays(twin));
  SeenPoints out;
  if (rays.size() < kFewestGateRays) return out;
  const auto wanted = static_cast<std::size_t>(&object - twin.objects.data());
  const FirstSurface first(twin);
  const Eigen::Vector3d camera_mm = twin.cameras.front().center_world_mm();
  std::vector<unsigned char> is_met(rays.size(), 0);
#pragma omp parallel for schedule(dynamic, 8)
  for (std::size_t i = 0; i < rays.size(); ++i)
    is_met[i] = first.along(camera_mm, cloud.p_world_mm[near[rays[i]].index]) == wanted ? 1 : 0;
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (is_met[i]) out.distance_mm.push_back(near[rays[i]].distance_mm);
  out.of_cloud_per_point = static_cast<double>(near.size()) / static_cast<double>(rays.size()) *
                           static_cast<double>(cloud.size()) / static_cast<double>(tried.size());
  return out;
}

/// Returns what is wrong with the gate around these points; empty where nothing is.
std::string gate_warning(const FitRequest& request, SeenPoints seen, double n_gated) {
  std::vector<double>& distance_mm = seen.distance_mm;
  if (distance_mm.size() < kFewestGateRays) return "";
  const auto share_within = [&](double limit_mm) {
    return static_cast<double>(
               std::ranges::count_if(distance_mm, [=](double d_mm) { return d_mm <= limit_mm; })) /
           static_cast<double>(distance_mm.size());
  };
  const double inside = share_within(request.gate_mm);
  if (inside < kLeastInside)
    return fmt::format(
        "{}: {:.0f} points lie within gate_mm = {:g} of the object, but of about {:.0f} where the camera "
        "sees it in the twin half lie more than {:.3g} mm off: the fit does not stand for the object; "
        "take a larger gate_mm, or check the poses of object, cameras and projector",
        request.object, n_gated, request.gate_mm,
        static_cast<double>(distance_mm.size()) * seen.of_cloud_per_point, median(distance_mm));
  const double outermost = inside - share_within(kOuterPart * request.gate_mm);
  if (outermost > kPiledUp * inside && 1.0 - inside > kLostBeyond)
    return fmt::format(
        "{}: gate_mm = {:g} cuts through the object: {:.0f} % of the points within it lie in its outermost "
        "tenth, and {:.0f} % of all points where the camera sees the object in the twin lie beyond; take a "
        "larger gate_mm, or check the poses of object, cameras and projector",
        request.object, request.gate_mm, 100.0 * outermost / inside, 100.0 * (1.0 - inside));
  return "";
}

}  // namespace

bool points_gather_about(const Object& object, double gate_mm, const PointCloud& cloud,
                         const ObjectFit& fit) {
  const std::vector<std::size_t> asked = evenly_spread(fit.index.size(), kMostAsked);
  const SurfaceGate inner_half(object, 0.5 * gate_mm);
  const auto inner = std::ranges::count_if(asked, [&](std::size_t k) {
    return std::isfinite(inner_half.distance_mm(cloud.p_world_mm[fit.index[k]]));
  });
  return !asked.empty() && static_cast<double>(inner) >= kGathered * static_cast<double>(asked.size());
}

std::vector<std::string> gate_warnings(const Twin& twin, const PointCloud& cloud,
                                       const std::vector<ObjectFit>& fits) {
  std::vector<std::string> out;
  if (twin.cameras.empty() || cloud.size() == 0) return out;
  if (!std::ranges::all_of(twin.objects, has_nominal_surface)) return out;
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const FitRequest& request = twin.measure.fits[k];
    const Object& object = *twin.find_object(request.object);
    if (points_gather_about(object, request.gate_mm, cloud, fits[k])) continue;
    std::string sentence = gate_warning(request, seen_points_near(twin, object, request.gate_mm, cloud),
                                        fits[k].numbers.at("n_gated"));
    if (!sentence.empty()) out.push_back(std::move(sentence));
  }
  return out;
}

}  // namespace fringetwin::measure
