// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "measure/fit/block_covariance.hpp"
#include "measure/fit/fits.hpp"
#include "measure/fit/point_set.hpp"
#include "measure/fit/robust.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/base/constants.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

/// Orthogonal-distance least squares has a closed form: weighted centroid and the eigenvector of the
/// smallest eigenvalue of the scatter matrix (e.g. Hoppe et al. 1992).
struct PlaneSolution {
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d scatter = Eigen::Vector3d::Zero();  ///< eigenvalues, ascending, mm^2 (sums)
  Eigen::Vector3d along = Eigen::Vector3d::UnitX(), across = Eigen::Vector3d::UnitY();  ///< eigenvectors 2, 1
};

bool solve_plane(const std::vector<Eigen::Vector3d>& p, const std::vector<std::size_t>& index,
                 const std::vector<double>& weight, PlaneSolution& plane) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double sum = 0.0;
  for (std::size_t k = 0; k < index.size(); ++k) {
    mean += weight[k] * p[index[k]];
    sum += weight[k];
  }
  if (!(sum > 0.0)) return false;
  mean /= sum;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < index.size(); ++k) {
    const Eigen::Vector3d d = p[index[k]] - mean;
    scatter.noalias() += weight[k] * d * d.transpose();
  }
  const SymmetricEigen eigen = symmetric_eigen(scatter);
  // a line has two small eigenvalues: rounding leaves them at 1e-16 of the largest
  if (!(eigen.values(1) > 1e-13 * eigen.values(2))) return false;
  plane = {mean, eigen.vectors.col(0), eigen.values, eigen.vectors.col(2), eigen.vectors.col(1)};
  return true;
}

}  // namespace

PlaneFit fit_plane(const std::vector<Eigen::Vector3d>& p_mm, const FitOptions& o) {
  constexpr std::size_t kParameters = 3;
  PlaneFit fit;
  fit.n_gated = p_mm.size();
  fit.offset_sigma_mm = kNaN;
  fit.tilt_covariance.setConstant(kNaN);
  const CentredPoints points(p_mm);
  if (!check_points(points, kParameters, "a plane", fit)) return fit;

  PlaneSolution plane;
  std::vector<std::size_t> all(p_mm.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  RobustModel robust;
  robust.n = p_mm.size();
  robust.min_points = kParameters;
  robust.smallest_scale = points.smallest_scale_mm();
  robust.distance = [&](std::size_t i) { return plane.normal.dot(points.p_mm[i] - plane.point); };
  robust.solve = [&](const std::vector<std::size_t>& index, const std::vector<double>& weight) {
    return solve_plane(points.p_mm, index, weight, plane);
  };
  const bool started = solve_plane(points.p_mm, all, std::vector<double>(all.size(), 1.0), plane);
  const RobustResult result = started ? robust_fit(robust, o) : RobustResult{};
  fit.n = result.ok ? result.index.size() : p_mm.size();
  fit.message = started ? result.message : "the points lie on a line: they do not determine a plane";
  if (!result.ok) return fit;

  double sum_sq = 0.0;
  for (const std::size_t i : result.index) sum_sq += std::pow(robust.distance(i), 2);
  const auto n = static_cast<double>(fit.n);
  fit.rms_mm = std::sqrt(sum_sq / n);
  fit.point_mm = points.centroid_mm + plane.point;
  // the viewer is taken to be at the world origin (normally the first camera)
  fit.normal = plane.normal.dot(fit.point_mm) > 0.0 ? Eigen::Vector3d(-plane.normal) : plane.normal;
  fit.usable = true;
  if (fit.n == kParameters) {
    fit.message = "as many points as parameters: no uncertainty";
    return fit;
  }
  // parameters: offset, tilt along the longest extent, tilt across it; orthogonal at the centroid
  const double s_sq = sum_sq / (n - kParameters);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3, 3);
  covariance.diagonal() = s_sq * Eigen::Vector3d(1.0 / n, 1.0 / plane.scatter[2], 1.0 / plane.scatter[1]);
  if (!o.block.empty()) {
    std::map<int, BlockSum> blocks;
    for (const std::size_t i : result.index) {
      const Eigen::Vector3d d = points.p_mm[i] - plane.point;
      const Eigen::Vector3d row(1.0, plane.along.dot(d), plane.across.dot(d));
      blocks.try_emplace(o.block[i], static_cast<int>(kParameters))
          .first->second.add(row.data(), plane.normal.dot(d));
    }
    covariance = block_covariance(blocks, covariance);
  }
  fit.offset_sigma_mm = std::sqrt(covariance(0, 0));
  const Eigen::Matrix<double, 3, 2> ways =
      (Eigen::Matrix<double, 3, 2>() << plane.along, plane.across).finished();
  fit.tilt_covariance = ways * covariance.bottomRightCorner<2, 2>() * ways.transpose();
  return fit;
}

namespace {

Eigen::Vector3d towards(const Eigen::Vector3d& normal, const Eigen::Vector3d& from,
                        const Eigen::Vector3d& viewer) {
  return normal.dot(viewer - from) < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

}  // namespace

void fit_shape(const PlaneShape& shape, const Gated& points, ObjectFit& row) {
  const PlaneFit fit = fit_plane(points.p_mm, robust_options(points));
  take_summary(fit, row);
  put(row, "point_mm", fit.point_mm);
  put(row, "normal", towards(fit.normal, fit.point_mm, points.viewer_mm));
  put(row, "offset_sigma_mm", fit.offset_sigma_mm);
  put_tilt_directions(row, row.vectors["normal"], shape.u_axis);
  put_across(row, "tilt_sigma_rad", fit.tilt_covariance);
}

std::vector<std::string> fit_keys(const PlaneShape&) { return {"point_mm", "normal"}; }

std::string form_indicator(const PlaneShape&) { return "plane_flatness"; }

double distance_mm(const PlaneShape& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - s.point_mm;
  const double height = s.normal.dot(d);
  if (!s.size_mm) return height;
  const double u = std::abs(s.u_axis.dot(d)) - 0.5 * s.size_mm->x();
  const double v = std::abs(s.normal.cross(s.u_axis).dot(d)) - 0.5 * s.size_mm->y();
  const double beside = std::hypot(std::max(u, 0.0), std::max(v, 0.0));
  return std::copysign(std::hypot(height, beside), height);
}

bool name_numbers(const PlaneShape& s, ObjectFit& row) {
  row.vectors["point_mm"] = s.point_mm;
  row.vectors["normal"] = s.normal;
  return true;
}

std::optional<Shape> fitted_shape(const PlaneShape&, const ObjectFit& row) {
  const Eigen::Vector3d& normal = row.vectors.at("normal");
  return PlaneShape{row.vectors.at("point_mm"), normal, {}, normal.unitOrthogonal()};
}

Marks marks_mm(const PlaneShape& s, const Eigen::Vector3d& near_mm) {
  Marks m = (near_mm - s.normal.dot(near_mm - s.point_mm) * s.normal).replicate<1, 4>();
  m.col(1) += kMarksArm_mm * s.normal;
  return m;
}

}  // namespace fringetwin::measure
