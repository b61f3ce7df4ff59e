// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <cmath>

#include "measure/fit/ceres_fit.hpp"
#include "measure/fit/fits.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::measure {
namespace {

struct SphereDistance final : DistanceModel {
  static constexpr int kParameters = 4;  ///< cx cy cz r
  int parameters() const override { return kParameters; }
  double distance(const double* x, const Eigen::Vector3d& p, double* dr_dx) const override {
    const Eigen::Vector3d v = p - Eigen::Vector3d(x[0], x[1], x[2]);
    const double length = v.norm();
    if (dr_dx) {
      const Eigen::Vector3d u = length > 0.0 ? Eigen::Vector3d(v / length) : Eigen::Vector3d::Zero();
      dr_dx[0] = -u.x();
      dr_dx[1] = -u.y();
      dr_dx[2] = -u.z();
      dr_dx[3] = -1.0;
    }
    return length - x[3];
  }
};

/// Linear least squares of |p|^2 = 2 c.p + k (Kasa): a start where none is given.
bool algebraic_sphere(const std::vector<Eigen::Vector3d>& p, double* x) {
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (const Eigen::Vector3d& q : p) {
    const Eigen::Vector4d row(2 * q.x(), 2 * q.y(), 2 * q.z(), 1.0);
    a += row * row.transpose();
    b += row * q.squaredNorm();
  }
  const Eigen::FullPivLU<Eigen::Matrix4d> lu(a);
  if (!lu.isInvertible()) return false;
  const Eigen::Vector4d s = lu.solve(b);
  const double r_sq = s[3] + s.head<3>().squaredNorm();
  if (!(r_sq > 0.0)) return false;
  Eigen::Map<Eigen::Vector3d>{x} = s.head<3>();
  x[3] = std::sqrt(r_sq);
  return true;
}

}  // namespace

SphereFit fit_sphere(const std::vector<Eigen::Vector3d>& p_mm, const SphereShape& start,
                     const FitOptions& o) {
  SphereFit fit;
  fit.n_gated = p_mm.size();
  fit.covariance.setConstant(kNaN);
  const CentredPoints points(p_mm);
  if (!check_points(points, SphereDistance::kParameters, "a sphere", fit)) return fit;

  double x[4] = {start.center_mm.x() - points.centroid_mm.x(), start.center_mm.y() - points.centroid_mm.y(),
                 start.center_mm.z() - points.centroid_mm.z(), start.radius_mm};
  if (!(start.radius_mm > 0.0) && !algebraic_sphere(points.p_mm, x)) {
    fit.message = "the points do not determine a sphere";
    return fit;
  }
  const SphereDistance model;
  const auto covariance = fit_robustly(
      model, points, o, "a sphere",
      [&](const std::vector<std::size_t>& index, const std::vector<double>& weight) {
        return minimise(model, points.p_mm, index, weight, o.max_iterations, x) && x[3] > 0.0;
      },
      x, fit);
  if (!covariance) return fit;
  fit.covariance = *covariance;
  fit.center_mm = points.centroid_mm + Eigen::Vector3d(x[0], x[1], x[2]);
  fit.radius_mm = x[3];
  return fit;
}

void fit_shape(const SphereShape& shape, const Gated& points, ObjectFit& row) {
  const SphereFit fit = fit_sphere(points.p_mm, shape, robust_options(points));
  take_summary(fit, row);
  const Eigen::Vector4d sigma = fit.covariance.diagonal().cwiseSqrt();
  put(row, "center_mm", fit.center_mm);
  put(row, "center_sigma_mm", Eigen::Vector3d(sigma.head<3>()));
  put(row, "radius_mm", fit.radius_mm);
  put(row, "radius_sigma_mm", sigma[3]);
}

std::vector<std::string> fit_keys(const SphereShape&) {
  return {"center_mm", "center_sigma_mm", "radius_mm", "radius_sigma_mm"};
}

std::string form_indicator(const SphereShape&) { return "sphere_form"; }

double distance_mm(const SphereShape& s, const Eigen::Vector3d& p) {
  return (p - s.center_mm).norm() - s.radius_mm;
}

bool name_numbers(const SphereShape& s, ObjectFit& row) {
  row.vectors["center_mm"] = s.center_mm;
  row.numbers["radius_mm"] = s.radius_mm;
  return true;
}

std::optional<Shape> fitted_shape(const SphereShape&, const ObjectFit& row) {
  return SphereShape{row.vectors.at("center_mm"), row.numbers.at("radius_mm")};
}

Marks marks_mm(const SphereShape& s, const Eigen::Vector3d&) { return s.center_mm.replicate<1, 4>(); }

}  // namespace fringetwin::measure
