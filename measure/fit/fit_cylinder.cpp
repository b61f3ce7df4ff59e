// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>

#include "measure/fit/ceres_fit.hpp"
#include "measure/fit/fits.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::measure {
namespace {

/// Tangent parameters about a base axis: the point moves in the plane across the base (u v), the axis
/// leans by (alpha beta), so there is no gauge freedom. x = u v alpha beta r.
struct CylinderDistance final : DistanceModel {
  static constexpr int kParameters = 5;
  Eigen::Vector3d point, axis, e1, e2;

  CylinderDistance(const Eigen::Vector3d& on_axis, const Eigen::Vector3d& unit_axis)
      : point(on_axis), axis(unit_axis) {
    set_tangents();
  }
  int parameters() const override { return kParameters; }

  Eigen::Vector3d leaned_axis(const double* x) const { return (axis + x[2] * e1 + x[3] * e2).normalized(); }
  Eigen::Vector3d moved_point(const double* x) const { return point + x[0] * e1 + x[1] * e2; }

  double distance(const double* x, const Eigen::Vector3d& p, double* dr_dx) const override {
    const Eigen::Vector3d a_raw = axis + x[2] * e1 + x[3] * e2;
    const double a_length = a_raw.norm();
    const Eigen::Vector3d a = a_raw / a_length;
    const Eigen::Vector3d d = p - moved_point(x);
    const double along = d.dot(a);
    const Eigen::Vector3d w = d - along * a;
    const double from_axis = w.norm();
    if (dr_dx) {
      // m is orthogonal to a, so the normalisation of a drops out of m . da
      const Eigen::Vector3d m = from_axis > 0.0 ? Eigen::Vector3d(w / from_axis) : Eigen::Vector3d::Zero();
      const double m1 = m.dot(e1), m2 = m.dot(e2);
      dr_dx[0] = -m1;
      dr_dx[1] = -m2;
      dr_dx[2] = -along * m1 / a_length;
      dr_dx[3] = -along * m2 / a_length;
      dr_dx[4] = -1.0;
    }
    return from_axis - x[4];
  }
  /// Makes the present solution the new base.
  void rebase(double* x) {
    point = moved_point(x);
    axis = leaned_axis(x);
    point -= axis * axis.dot(point);  // nearest the centroid, which is the origin here
    set_tangents();
    x[0] = x[1] = x[2] = x[3] = 0.0;
  }
  void set_tangents() {
    e1 = axis.unitOrthogonal();
    e2 = axis.cross(e1);
  }
};

}  // namespace

CylinderFit fit_cylinder(const std::vector<Eigen::Vector3d>& p_mm, const CylinderShape& start,
                         const FitOptions& o) {
  constexpr int kRebases = 10;
  CylinderFit fit;
  fit.n_gated = p_mm.size();
  fit.radius_sigma_mm = kNaN;
  const CentredPoints points(p_mm);
  if (!check_points(points, CylinderDistance::kParameters, "a cylinder", fit)) return fit;
  if (!(start.axis.norm() > 0.0) || !(start.radius_mm > 0.0)) {
    fit.message = "a cylinder fit needs a start with an axis and a radius";
    return fit;
  }
  CylinderDistance model(start.point_mm - points.centroid_mm, start.axis.normalized());
  double x[5] = {0, 0, 0, 0, start.radius_mm};
  model.rebase(x);

  const auto solve = [&](const std::vector<std::size_t>& index, const std::vector<double>& weight) {
    for (int k = 0; k < kRebases; ++k) {
      if (!minimise(model, points.p_mm, index, weight, o.max_iterations, x) || !(x[4] > 0.0)) return false;
      const double leaned_rad = std::hypot(x[2], x[3]);
      model.rebase(x);
      if (leaned_rad < 1e-3) break;  // the tangent approximation is a parametrisation, not an error
    }
    return true;
  };
  const auto covariance = fit_robustly(model, points, o, "a cylinder", solve, x, fit);
  if (!covariance) return fit;
  fit.axis = model.axis.dot(start.axis) < 0.0 ? Eigen::Vector3d(-model.axis) : model.axis;
  fit.point_mm = points.centroid_mm + model.point;
  fit.radius_mm = x[4];
  fit.radius_sigma_mm = std::sqrt((*covariance)(4, 4));
  const Eigen::Matrix<double, 3, 2> ways = (Eigen::Matrix<double, 3, 2>() << model.e1, model.e2).finished();
  fit.shift_covariance = ways * covariance->topLeftCorner<2, 2>() * ways.transpose();
  fit.tilt_covariance = ways * covariance->block<2, 2>(2, 2) * ways.transpose();
  return fit;
}

void fit_shape(const CylinderShape& shape, const Gated& points, ObjectFit& row) {
  const CylinderFit fit = fit_cylinder(points.p_mm, shape, robust_options(points));
  take_summary(fit, row);
  put(row, "point_mm", fit.point_mm);
  put(row, "axis", fit.axis);
  put(row, "radius_mm", fit.radius_mm);
  put(row, "radius_sigma_mm", fit.radius_sigma_mm);
  put_tilt_directions(row, fit.axis, shape.axis.unitOrthogonal());
  put_across(row, "axis_sigma_rad", fit.tilt_covariance);
  put_across(row, "axis_shift_sigma_mm", fit.shift_covariance);
}

std::vector<std::string> fit_keys(const CylinderShape&) {
  return {"point_mm", "axis", "radius_mm", "radius_sigma_mm"};
}

std::string form_indicator(const CylinderShape&) { return ""; }

double distance_mm(const CylinderShape& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - s.point_mm;
  const double along = s.axis.dot(d);
  const double radial = (d - along * s.axis).norm() - s.radius_mm;
  if (!s.length_mm) return radial;
  return std::copysign(std::hypot(radial, std::max(std::abs(along) - 0.5 * *s.length_mm, 0.0)), radial);
}

bool name_numbers(const CylinderShape& s, ObjectFit& row) {
  row.vectors["point_mm"] = s.point_mm;
  row.vectors["axis"] = s.axis;
  row.numbers["radius_mm"] = s.radius_mm;
  return true;
}

std::optional<Shape> fitted_shape(const CylinderShape&, const ObjectFit& row) {
  return CylinderShape{row.vectors.at("point_mm"), row.vectors.at("axis"), row.numbers.at("radius_mm"), {}};
}

Marks marks_mm(const CylinderShape& s, const Eigen::Vector3d& near_mm) {
  Marks m = (s.point_mm + s.axis.dot(near_mm - s.point_mm) * s.axis).replicate<1, 4>();
  m.col(1) += kMarksArm_mm * s.axis;
  return m;
}

}  // namespace fringetwin::measure
