// SPDX-License-Identifier: Apache-2.0
// Fits the objects of a twin to a cloud of points: every [[measure.fit]] becomes one row of numbers.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "measure/fit/closest_point.hpp"
#include "measure/fit/fit_types.hpp"
#include "measure/points/points.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Returns a row for every [[measure.fit]] of the twin: points within gate_mm of the object's nominal
/// surface, then robust. Too few points: listed with n, usable = false and a warning.
std::vector<ObjectFit> fit_objects(const Twin& twin, const PointCloud& cloud);

/// Returns the numbers of an object's nominal shape under the keys that a fit of it has; nullopt for a mesh
/// and a measured surface, which are registered instead.
std::optional<ObjectFit> nominal_fit(const Object& object);

/// Tells which points lie near an object's nominal surface.
class SurfaceGate {
 public:
  /// Keeps a reference to the object.
  SurfaceGate(const Object& object, double gate_mm);
  /// Returns the distance of a world point to the surface, without a sign; infinity beyond the gate, and for
  /// a shape without a surface of its own.
  double distance_mm(const Eigen::Vector3d& p_world_mm) const;

 private:
  const Object& object_;
  double gate_mm_;
  std::shared_ptr<const MeshDistance> mesh_;
  Pose T_object_world_;
};

/// Returns whether the object has a surface before any capture: "measured" has none, nor has a mesh that is
/// not loaded.
bool has_nominal_surface(const Object& object);

/// Returns the signed distance of a world point to an object's nominal surface (mesh: closest surface point).
double surface_distance_mm(const Object& object, const Eigen::Vector3d& p_world_mm);

}  // namespace fringetwin::measure
