// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "measure/fit/closest_point.hpp"
#include "measure/fit/fits.hpp"
#include "measure/fit/icp.hpp"
#include "measure/fit/robust.hpp"
#include "measure/fit/shape_fits.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::measure {
namespace {

constexpr std::size_t kIcpPoints = 6000;
constexpr std::size_t kGaussNewtonPoints = 20000;
constexpr double kFlickerMm = 1e-4;

std::vector<Eigen::Vector3d> pick(const std::vector<Eigen::Vector3d>& p, std::size_t count) {
  if (p.size() <= count) return p;
  std::mt19937_64 random(40);
  std::vector<Eigen::Vector3d> q;
  q.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t first = k * p.size() / count, last = (k + 1) * p.size() / count;
    q.push_back(p[first + random() % (last - first)]);
  }
  return q;
}

std::vector<ClosestPoint> closest_points(const MeshDistance& surface, const Pose& T,
                                         const std::vector<Eigen::Vector3d>& p, double limit_mm) {
  std::vector<ClosestPoint> hits(p.size());
  const auto n = static_cast<std::ptrdiff_t>(p.size());
#pragma omp parallel for schedule(dynamic, 512)
  for (std::ptrdiff_t i = 0; i < n; ++i) hits[i] = surface.query(T * p[i], limit_mm);
  return hits;
}

/// Median distance to the surface, points beyond the limit counting as the limit: falls when a pose
/// gets better, whatever the outliers do.
double median_distance(const MeshDistance& surface, const Pose& T, const std::vector<Eigen::Vector3d>& p,
                       double limit_mm) {
  std::vector<double> distance;
  distance.reserve(p.size());
  for (const ClosestPoint& hit : closest_points(surface, T, p, limit_mm))
    distance.push_back(hit.triangle < 0 ? limit_mm : std::abs(hit.signed_distance_mm));
  return upper_median(distance);
}

/// Solves J^T J x = -J^T r leaving out directions the surface does not determine (a plane slides in
/// itself, a sphere turns about its centre).
Eigen::Matrix<double, 6, 1> solve_determined(const Eigen::Matrix<double, 6, 6>& jtj,
                                             const Eigen::Matrix<double, 6, 1>& jtr) {
  const SymmetricEigen eigen = symmetric_eigen(jtj);
  Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
  for (int k = 0; k < 6; ++k) {
    const double value = eigen.values(k);
    if (value < 1e-7 * eigen.values(5)) continue;
    step -= eigen.vectors.col(k) * (eigen.vectors.col(k).dot(jtr) / value);
  }
  return step;
}

/// Gauss-Newton on the signed distances to the exact closest points, Tukey weights. The rotation is
/// about the centroid and its unit is scaled by the extent, so that all six columns are in mm.
/// False when fewer than six points are near the surface or the last of `steps` steps still moved.
bool gauss_newton(const MeshDistance& surface, const std::vector<Eigen::Vector3d>& p, double gate_mm,
                  int steps, Pose& T) {
  double last_step_mm = std::numeric_limits<double>::infinity();
  for (int k = 0; k < steps; ++k) {
    const std::vector<ClosestPoint> hits = closest_points(surface, T, p, gate_mm);
    std::vector<double> distance;
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (hits[i].triangle < 0) continue;
      distance.push_back(hits[i].signed_distance_mm);
      centroid += T * p[i];
    }
    if (distance.size() < 6) return false;
    centroid /= static_cast<double>(distance.size());
    const double scale = std::max(mad_sigma(distance), 1e-7);
    double extent_sq = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (hits[i].triangle >= 0) extent_sq += (T * p[i] - centroid).squaredNorm();
    const double extent = std::sqrt(extent_sq / static_cast<double>(distance.size()));
    if (!(extent > 0.0)) return false;
    Eigen::Matrix<double, 6, 6> jtj = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> jtr = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (hits[i].triangle < 0) continue;
      const double r = hits[i].signed_distance_mm;
      const double w = robust_weight(RobustLoss::tukey, r / scale);
      if (w <= 0.0) continue;
      const Eigen::Vector3d q = T * p[i];
      // direction of growing distance: away from the surface point, or the face normal when on it
      const Eigen::Vector3d away = q - hits[i].point_mm;
      const Eigen::Vector3d n = std::abs(r) > 1e-9 ? Eigen::Vector3d(away / r) : hits[i].normal;
      Eigen::Matrix<double, 6, 1> row;
      row << (q - centroid).cross(n) / extent, n;
      jtj.noalias() += w * row * row.transpose();
      jtr += w * r * row;
    }
    const Eigen::Matrix<double, 6, 1> step = solve_determined(jtj, jtr);
    if (!step.allFinite()) return false;
    const Eigen::Matrix3d R = rotation_from_vector(step.head<3>() / extent);
    T = Pose{R, centroid - R * centroid + step.tail<3>()} * T;
    last_step_mm = step.norm();
    if (last_step_mm < 1e-7) return true;
  }
  // closest triangles may flicker: what is left then is far below anything reported
  return last_step_mm < kFlickerMm;
}

void fill_statistics(const MeshDistance& surface, const std::vector<Eigen::Vector3d>& p, double gate_mm,
                     const Pose& T_object_measured, MeshFit& fit) {
  const std::vector<ClosestPoint> hits = closest_points(surface, T_object_measured, p, gate_mm);
  double sum_sq = 0.0;
  std::size_t within = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (hits[i].triangle < 0) continue;
    const double d = hits[i].signed_distance_mm;
    fit.index.push_back(i);
    fit.deviation_mm.push_back(static_cast<float>(d));
    sum_sq += d * d;
    within += std::abs(d) <= 0.010;
  }
  fit.n = fit.index.size();
  if (fit.n == 0) return;
  fit.rms_mm = std::sqrt(sum_sq / static_cast<double>(fit.n));
  fit.within_10um = static_cast<double>(within) / static_cast<double>(fit.n);
}

}  // namespace

MeshFit register_mesh(const std::vector<Eigen::Vector3d>& p_mm, const MeshShape& cad, double gate_mm,
                      int gauss_newton_steps) {
  constexpr std::size_t kFewest = 6;
  MeshFit fit;
  fit.n = fit.n_gated = p_mm.size();
  if (p_mm.size() < kFewest) {
    fit.message = "only " + std::to_string(p_mm.size()) + " points: a registration needs at least 6";
    return fit;
  }
  for (const Eigen::Vector3d& p : p_mm)
    if (!p.allFinite()) {
      fit.message = "a point is not finite";
      return fit;
    }
  FT_CHECK(cad.mesh != nullptr, "mesh not loaded");
  const std::shared_ptr<const MeshDistance> surface = mesh_distance_for(cad.mesh);
  // all stages work in the CAD frame; they start at the nominal pose
  Pose T = cad.T_world_object.inverse();
  const std::vector<Eigen::Vector3d> coarse = pick(p_mm, kIcpPoints);
  const IcpTarget target(*cad.mesh);
  double best = median_distance(*surface, T, coarse, gate_mm);
  for (const IcpKind kind : {IcpKind::point_to_point, IcpKind::point_to_plane}) {
    // ICP knows only samples of the surface and may slide; the exact distance decides
    const Pose tried = run_icp(kind, coarse, target, T, gate_mm);
    const double distance = median_distance(*surface, tried, coarse, gate_mm);
    if (distance < best) {
      best = distance;
      T = tried;
    }
  }
  Pose refined = T;
  if (gauss_newton(*surface, pick(p_mm, kGaussNewtonPoints), gate_mm, gauss_newton_steps, refined))
    T = refined;
  else
    fit.message = "the registration did not settle: too few points near the surface, or a poor start";
  fill_statistics(*surface, p_mm, gate_mm, T, fit);
  fit.T_object_measured = cad.T_world_object * T;
  fit.usable = fit.n >= kFewest && fit.message.empty();
  if (fit.n < p_mm.size() / 2 && fit.usable)
    fit.message = "less than half of the points lie within the gate of the registered surface";
  return fit;
}

void fit_shape(const MeshShape& shape, const Gated& points, ObjectFit& row) {
  const MeshFit fit = register_mesh(points.p_mm, shape, points.gate_mm);
  take_summary(fit, row);
  std::vector<double> absolute;
  double sum = 0.0;
  for (const float d : fit.deviation_mm) {
    sum += static_cast<double>(d);
    absolute.push_back(std::abs(static_cast<double>(d)));
  }
  const bool some = fit.usable && !absolute.empty();
  row.numbers["rms_all_mm"] = some ? fit.rms_mm : kNaN;  // nothing within the gate is left out
  row.numbers["mean_mm"] = some ? sum / static_cast<double>(absolute.size()) : kNaN;
  row.numbers["p95_mm"] = some ? lower_quantile(absolute, 0.95) : kNaN;
  row.numbers["within_10um"] = some ? fit.within_10um : kNaN;
  const RotTrans rt = rt_from_pose(fit.T_object_measured);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  row.vectors["T_object_measured_r_rad"] = some ? Eigen::Vector3d(rt.head<3>()) : none;
  row.vectors["T_object_measured_t_mm"] = some ? Eigen::Vector3d(rt.tail<3>()) : none;
  row.index = fit.index;
  row.deviation_mm = fit.deviation_mm;
}

double distance_mm(const MeshShape& s, const Eigen::Vector3d& p) {
  return mesh_distance_for(s.mesh)->query(s.T_world_object.inverse() * p).signed_distance_mm;
}

bool name_numbers(const MeshShape&, ObjectFit&) { return false; }

std::vector<std::string> fit_keys(const MeshShape&) { return {}; }

std::string form_indicator(const MeshShape&) { return ""; }

std::optional<Shape> fitted_shape(const MeshShape&, const ObjectFit&) { return std::nullopt; }

}  // namespace fringetwin::measure
