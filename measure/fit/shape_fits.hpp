// SPDX-License-Identifier: Apache-2.0
// What the fits of objects need of every shape: a fit to points, a distance, and the names of its numbers.
// Each function has one overload per shape, in that shape's own file, and is called through std::visit
// without a generic fallback.
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
  std::vector<Eigen::Vector3d> p_mm = {};
  std::vector<int> block = {};  ///< image block of each point's source pixel; empty when unknown
  Eigen::Vector3d viewer_mm = Eigen::Vector3d::Zero();
  double gate_mm = 0.0;
};

/// Copies what all fits have in common into a row of results.
void take_summary(const FitSummary& fit, ObjectFit& row);
/// Returns the options of a robust fit to these points.
FitOptions robust_options(const Gated& points);

/// Writes a number or a vector of a fit into its row, whose summary is there already: NaN where the fit is
/// not usable.
void put(ObjectFit& row, const std::string& key, double value);
void put(ObjectFit& row, const std::string& key, const Eigen::Vector3d& value);
/// Writes the two directions across a fitted normal or axis along which its errors are stated. `first`, of
/// the nominal shape, lies near the first of them, so that all fits of an object have the same.
void put_tilt_directions(ObjectFit& row, const Eigen::Vector3d& normal_or_axis, const Eigen::Vector3d& first);
/// Writes the standard errors along these directions under KEY_0 and KEY_1.
void put_across(ObjectFit& row, const std::string& key, const Eigen::Matrix3d& covariance);

/// Four points that tell where a shape is, its bounds left out: equal for two of its kind at one place.
using Marks = Eigen::Matrix<double, 3, 4>;
constexpr double kMarksArm_mm = 100.0;  ///< from the first mark to the others: it weighs turns against shifts

/// Declares, for the shape S in a file of its own,
/// - fit_shape(): fits the shape to the points, starting from the nominal one, and writes numbers, vectors
/// and
///   their sigmas into the row under the keys of result.json; NaN where the fit is not usable;
/// - distance_mm(): returns the signed distance of a world point to the surface, positive outside; NaN for a
///   shape without one;
/// - name_numbers(): writes the shape's own numbers and vectors into the row under the keys that a fit of it
///   has. Returns false, and writes nothing, for a shape whose fit is a registration and not a set of
///   numbers;
/// - fit_keys(): returns the keys that result.json has for every fit of it, also for one that is not usable;
/// - fitted_shape(): returns the surface that a row of its fit describes, unbounded; nullopt where
///   name_numbers() has none;
/// - form_indicator(): returns the name of the indicator that its deviations from the fit make
///   (docs/metrics/geometry.md, "Indicators"), "" for a shape that has none;
/// - marks_mm(): returns the points that tell where it is, the first as near as it can be to near_mm.
#define FT_DECLARE(S)                                                        \
  void fit_shape(const S& nominal, const Gated& points, ObjectFit& row);     \
  double distance_mm(const S& shape, const Eigen::Vector3d& p_world_mm);     \
  bool name_numbers(const S& shape, ObjectFit& row);                         \
  std::vector<std::string> fit_keys(const S& shape);                         \
  std::optional<Shape> fitted_shape(const S& nominal, const ObjectFit& row); \
  std::string form_indicator(const S& shape);                                \
  Marks marks_mm(const S& shape, const Eigen::Vector3d& near_mm);
FT_SHAPES(FT_DECLARE)
#undef FT_DECLARE

}  // namespace fringetwin::measure
