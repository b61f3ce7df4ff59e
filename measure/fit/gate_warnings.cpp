// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/gate_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "measure/fit/object_fits.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

/// Rays that are followed: a share of a half is known to 1 % of all and to 10 % of an object that has a
/// hundredth of the points.
constexpr std::size_t kMostGateRays = 2000;
constexpr std::size_t kFewestGateRays = 20;
/// Of the object's points within the gate: of fewer no robust fit is told which surface is the object's.
constexpr double kLeastInside = 0.5;
/// Of the points within the gate that lie in its outermost tenth, and of all that lie beyond it. Points that
/// fill the gate evenly have a tenth there; points of a right twin are noise about its middle.
constexpr double kOuterPart = 0.9, kPiledUp = 0.05, kLostBeyond = 0.05;

/// Returns whether there is a nominal surface to meet: "measured" has none, nor has a mesh that is not
/// loaded.
bool has_surface(const Object& object) {
  if (const auto* mesh = std::get_if<MeshShape>(&object.shape)) return mesh->mesh != nullptr;
  return !std::holds_alternative<MeasuredShape>(object.shape);
}

/// Tells which object of the twin a ray meets first, by steps that are as long as the nearest surface is far.
class FirstSurface {
 public:
  explicit FirstSurface(const Twin& twin) {
    for (const Object& object : twin.objects)
      surfaces_.emplace_back(object, std::numeric_limits<double>::infinity());
  }
  /// Returns the distance of a point to the surface of an object, without a sign.
  double distance_mm(std::size_t object, const Eigen::Vector3d& p_mm) const {
    return surfaces_[object].distance_mm(p_mm);
  }
  /// Returns the object, or how many there are where the ray through the point meets none.
  std::size_t along(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& through_mm) const {
    constexpr int kMostRaySteps = 200;     // a ray that needs more only grazes
    constexpr double kFarthest = 4.0;   // of the point's distance
    constexpr double kTouching = 1e-4;  // of the point's distance: much less than any gate
    const double range_mm = (through_mm - from_mm).norm();
    const Eigen::Vector3d direction = (through_mm - from_mm) / range_mm;
    double at_mm = 0.0;
    for (int step = 0; step < kMostRaySteps && at_mm < kFarthest * range_mm; ++step) {
      double nearest_mm = std::numeric_limits<double>::infinity();
      std::size_t object = surfaces_.size();
      for (std::size_t k = 0; k < surfaces_.size(); ++k)
        if (const double d_mm = distance_mm(k, from_mm + at_mm * direction); d_mm < nearest_mm)
          nearest_mm = d_mm, object = k;
      if (nearest_mm < kTouching * range_mm) return object;
      at_mm += nearest_mm;
    }
    return surfaces_.size();
  }
  std::size_t size() const { return surfaces_.size(); }

 private:
  std::vector<SurfaceGate> surfaces_;
};

/// Returns the distances of points to the surface of the object that the camera sees there in the twin, by
/// object.
std::vector<std::vector<double>> distances_mm(const Twin& twin, const PointCloud& cloud) {
  const FirstSurface first(twin);
  const Eigen::Vector3d camera_mm = twin.cameras.front().center_world_mm();
  const std::size_t rays = std::min(kMostGateRays, cloud.size());
  std::vector<std::size_t> object(rays);
  std::vector<double> distance(rays);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(rays); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector3d& p_mm = cloud.p_world_mm[k * cloud.size() / rays];
    object[k] = first.along(camera_mm, p_mm);
    if (object[k] < first.size()) distance[k] = first.distance_mm(object[k], p_mm);
  }
  std::vector<std::vector<double>> out(first.size());
  for (std::size_t k = 0; k < rays; ++k)
    if (object[k] < first.size()) out[object[k]].push_back(distance[k]);
  return out;
}

/// Returns what is wrong with the gate around these distances; empty where nothing is.
std::string gate_warning(const FitRequest& request, std::vector<double> distance_mm, double n_gated,
                         double points_per_ray) {
  if (distance_mm.size() < kFewestGateRays) return "";
  const auto share_within = [&](double limit_mm) {
    return static_cast<double>(
               std::ranges::count_if(distance_mm, [=](double d_mm) { return d_mm <= limit_mm; })) /
           static_cast<double>(distance_mm.size());
  };
  const double inside = share_within(request.gate_mm);
  const double n = static_cast<double>(distance_mm.size()) * points_per_ray;
  if (inside < kLeastInside)
    return fmt::format(
        "{}: {:.0f} points lie within gate_mm = {:g} of the object, but of about {:.0f} where the camera "
        "sees it in the twin half lie more than {:.3g} mm off: the fit does not stand for the object; "
        "take a larger gate_mm, or check the poses of object, cameras and projector",
        request.object, n_gated, request.gate_mm, n, median(distance_mm));
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

std::vector<std::string> gate_warnings(const Twin& twin, const PointCloud& cloud,
                                       const std::vector<ObjectFit>& fits) {
  std::vector<std::string> out;
  if (twin.measure.fits.empty() || twin.cameras.empty() || cloud.size() == 0) return out;
  if (!std::ranges::all_of(twin.objects, has_surface)) return out;
  const std::vector<std::vector<double>> by_object = distances_mm(twin, cloud);
  const double points_per_ray =
      static_cast<double>(cloud.size()) / static_cast<double>(std::min(kMostGateRays, cloud.size()));
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const FitRequest& request = twin.measure.fits[k];
    const auto object = static_cast<std::size_t>(twin.find_object(request.object) - twin.objects.data());
    std::string sentence =
        gate_warning(request, by_object[object], fits[k].numbers.at("n_gated"), points_per_ray);
    if (!sentence.empty()) out.push_back(std::move(sentence));
  }
  return out;
}

}  // namespace fringetwin::measure
