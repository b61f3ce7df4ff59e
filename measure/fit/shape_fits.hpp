// SPDX-License-Identifier: Apache-2.0
// What the fits of objects need of every shape: a fit to points, a distance, and the names of its numbers.
// Each function has one overload per shape, in that shape's own file unless it is a list, and is called
// through std::visit without a generic fallback.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "twin/shape/shape.hpp"

namespace fringetwin::measure {

/// The points of one fit and where they come from.
struct Gated {
  std::vector<Eigen::Vector3d> p_mm;
  std::vector<int> block;  ///< image block of each point's source pixel; empty when unknown
  Eigen::Vector3d viewer_mm = Eigen::Vector3d::Zero();
  double gate_mm = 0.0;
};

/// Copies what all fits have in common into a row of results.
void take_summary(const FitSummary& fit, ObjectFit& row);
/// Returns the options of a robust fit to these points.
FitOptions robust_options(const Gated& points);

/// Fits the shape to the points, starting from the nominal one, and writes numbers, vectors and their sigmas
/// into the row under the keys of result.json; NaN where the fit is not usable.
void fit_shape(const SphereShape& nominal, const Gated& points, ObjectFit& row);
void fit_shape(const PlaneShape& nominal, const Gated& points, ObjectFit& row);
void fit_shape(const CylinderShape& nominal, const Gated& points, ObjectFit& row);
void fit_shape(const MeshShape& nominal, const Gated& points, ObjectFit& row);
void fit_shape(const MeasuredShape& nominal, const Gated& points, ObjectFit& row);

/// Returns the signed distance of a world point to the surface, positive outside; NaN for a shape without
/// one.
double distance_mm(const SphereShape& s, const Eigen::Vector3d& p_world_mm);
double distance_mm(const PlaneShape& s, const Eigen::Vector3d& p_world_mm);
double distance_mm(const CylinderShape& s, const Eigen::Vector3d& p_world_mm);
double distance_mm(const MeshShape& s, const Eigen::Vector3d& p_world_mm);
double distance_mm(const MeasuredShape& s, const Eigen::Vector3d& p_world_mm);

/// Writes the shape's own numbers and vectors into the row under the keys that a fit of it has. Returns
/// false, and writes nothing, for a shape whose fit is a registration and not a set of numbers.
bool name_numbers(const SphereShape& s, ObjectFit& row);
bool name_numbers(const PlaneShape& s, ObjectFit& row);
bool name_numbers(const CylinderShape& s, ObjectFit& row);
bool name_numbers(const MeshShape& s, ObjectFit& row);
bool name_numbers(const MeasuredShape& s, ObjectFit& row);

/// Returns the keys that result.json has for every fit of the shape, also for one that is not usable.
inline std::vector<std::string> fit_keys(const SphereShape&) {
  return {"center_mm", "center_sigma_mm", "radius_mm", "radius_sigma_mm"};
}
inline std::vector<std::string> fit_keys(const PlaneShape&) { return {"point_mm", "normal"}; }
inline std::vector<std::string> fit_keys(const CylinderShape&) {
  return {"point_mm", "axis", "radius_mm", "radius_sigma_mm"};
}
inline std::vector<std::string> fit_keys(const MeshShape&) { return {}; }
inline std::vector<std::string> fit_keys(const MeasuredShape&) { return {}; }

/// Returns the surface that a row of this shape's fit describes, unbounded; nullopt where name_numbers() has
/// none.
std::optional<Shape> fitted_shape(const SphereShape& nominal, const ObjectFit& row);
std::optional<Shape> fitted_shape(const PlaneShape& nominal, const ObjectFit& row);
std::optional<Shape> fitted_shape(const CylinderShape& nominal, const ObjectFit& row);
std::optional<Shape> fitted_shape(const MeshShape& nominal, const ObjectFit& row);
std::optional<Shape> fitted_shape(const MeasuredShape& nominal, const ObjectFit& row);

}  // namespace fringetwin::measure
