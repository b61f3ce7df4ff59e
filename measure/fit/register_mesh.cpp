// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "measure/fit/block_covariance.hpp"
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
constexpr std::size_t kFewestPoints = 6;
constexpr double kFlickerMm = 1e-4;
constexpr double kDetermined = 1e-7;  ///< least eigenvalue of a direction that counts, over the largest

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Returns at most `count` elements of a list, the same places of every list of that length.
template <class T>
std::vector<T> pick(const std::vector<T>& p, std::size_t count) {
  if (p.size() <= count) return p;
  std::mt19937_64 random(40);
  std::vector<T> q;
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
Vector6 solve_determined(const Matrix6& jtj, const Vector6& jtr) {
  const SymmetricEigen eigen = symmetric_eigen(jtj);
  Vector6 step = Vector6::Zero();
  for (int k = 0; k < 6; ++k) {
    const double value = eigen.values(k);
    if (value < kDetermined * eigen.values(5)) continue;
    step -= eigen.vectors.col(k) * (eigen.vectors.col(k).dot(jtr) / value);
  }
  return step;
}

/// The points near the surface, their distances from it, and the derivatives of these by a small turn about
/// the points' centroid, whose unit is scaled by the extent so that all six are in mm, and a shift.
struct Linearised {
  std::vector<std::size_t> index;
  std::vector<double> distance_mm;
  std::vector<Vector6> derivative;
  Eigen::Vector3d centroid_mm = Eigen::Vector3d::Zero();
  double extent_mm = 0.0, scale_mm = 0.0;  ///< scale: robust sigma of the distances

  double weight(std::size_t k) const { return robust_weight(RobustLoss::tukey, distance_mm[k] / scale_mm); }
};

/// Returns nothing when fewer than six points are near the surface at pose T.
std::optional<Linearised> linearise(const MeshDistance& surface, const std::vector<Eigen::Vector3d>& p,
                                    double gate_mm, const Pose& T) {
  const std::vector<ClosestPoint> hits = closest_points(surface, T, p, gate_mm);
  Linearised at;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (hits[i].triangle < 0) continue;
    at.index.push_back(i);
    at.distance_mm.push_back(hits[i].signed_distance_mm);
    at.centroid_mm += T * p[i];
  }
  if (at.index.size() < kFewestPoints) return std::nullopt;
  at.centroid_mm /= static_cast<double>(at.index.size());
  std::vector<double> distance = at.distance_mm;
  at.scale_mm = std::max(mad_sigma(distance), 1e-7);
  double extent_sq = 0.0;
  for (const std::size_t i : at.index) extent_sq += (T * p[i] - at.centroid_mm).squaredNorm();
  at.extent_mm = std::sqrt(extent_sq / static_cast<double>(at.index.size()));
  if (!(at.extent_mm > 0.0)) return std::nullopt;
  for (const std::size_t i : at.index) {
    const double r = hits[i].signed_distance_mm;
    const Eigen::Vector3d q = T * p[i];
    // direction of growing distance: away from the surface point, or the face normal when on it
    const Eigen::Vector3d away = q - hits[i].point_mm;
    const Eigen::Vector3d n = std::abs(r) > 1e-9 ? Eigen::Vector3d(away / r) : hits[i].normal;
    at.derivative.emplace_back() << (q - at.centroid_mm).cross(n) / at.extent_mm, n;
  }
  return at;
}

/// Gauss-Newton on the signed distances to the exact closest points, Tukey weights.
/// False when fewer than six points are near the surface or the last of `steps` steps still moved.
bool gauss_newton(const MeshDistance& surface, const std::vector<Eigen::Vector3d>& p, double gate_mm,
                  int steps, Pose& T) {
  double last_step_mm = std::numeric_limits<double>::infinity();
  for (int k = 0; k < steps; ++k) {
    const std::optional<Linearised> at = linearise(surface, p, gate_mm, T);
    if (!at) return false;
    Matrix6 jtj = Matrix6::Zero();
    Vector6 jtr = Vector6::Zero();
    for (std::size_t i = 0; i < at->index.size(); ++i) {
      const double w = at->weight(i);
      if (w <= 0.0) continue;
      jtj.noalias() += w * at->derivative[i] * at->derivative[i].transpose();
      jtr += w * at->distance_mm[i] * at->derivative[i];
    }
    const Vector6 step = solve_determined(jtj, jtr);
    if (!step.allFinite()) return false;
    const Eigen::Matrix3d R = rotation_from_vector(step.head<3>() / at->extent_mm);
    T = Pose{R, at->centroid_mm - R * at->centroid_mm + step.tail<3>()} * T;
    last_step_mm = step.norm();
    if (last_step_mm < 1e-7) return true;
  }
  // closest triangles may flicker: what is left then is far below anything reported
  return last_step_mm < kFlickerMm;
}

/// Returns MeshFit::covariance at the minimum: block_covariance() of the directions that the surface
/// determines. A point pulls by psi = w r, and the curvature is the derivative of that, not w.
Matrix6 registration_covariance(const Linearised& at, const std::vector<int>& block) {
  const std::size_t n = at.index.size();
  std::vector<double> pull(n), curvature(n);
  Matrix6 all = Matrix6::Zero(), scatter = Matrix6::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const double w = at.weight(i), root = std::sqrt(w);
    pull[i] = w * at.distance_mm[i];
    curvature[i] = root * (5.0 * root - 4.0);
    const Matrix6 square = at.derivative[i] * at.derivative[i].transpose();
    all += curvature[i] * square;
    scatter += pull[i] * pull[i] * square;
  }
  const SymmetricEigen eigen = symmetric_eigen(all);
  const Eigen::Index m = (eigen.values.array() >= kDetermined * eigen.values(5)).count();
  const Eigen::MatrixXd ways = eigen.vectors.rightCols(m), others = eigen.vectors.leftCols(6 - m);
  std::map<int, BlockSum> blocks;
  for (std::size_t i = 0; i < n && !block.empty(); ++i) {
    BlockSum& sum = blocks.try_emplace(block[at.index[i]], static_cast<int>(m)).first->second;
    const Eigen::VectorXd row = ways.transpose() * at.derivative[i];
    sum.jtj += curvature[i] * row * row.transpose();
    sum.jtr += pull[i] * row;
  }
  const Eigen::MatrixXd solved = ways * eigen.values.tail(m).cwiseInverse().asDiagonal();
  const Eigen::MatrixXd independent =
      static_cast<double>(n) / (static_cast<double>(n) - 6.0) * solved.transpose() * scatter * solved;
  const Matrix6 scaled = ways * block_covariance(blocks, independent) * ways.transpose() +
                         kUndeterminedMm * kUndeterminedMm * others * others.transpose();
  Vector6 unit = Vector6::Ones();
  unit.head<3>() /= at.extent_mm;
  return unit.asDiagonal() * scaled * unit.asDiagonal();
}

/// Returns the standard errors of the turn and of where it carries what lies at `at_mm` in the object's
/// frame, both written in the frame to which R turns; NaN for what the surface does not determine.
Vector6 pose_sigmas(const MeshFit& fit, const Eigen::Vector3d& at_mm, const Eigen::Matrix3d& R) {
  constexpr double kNoEstimate = 1.0;  // mm or rad
  Matrix6 to = Matrix6::Zero();
  to.topLeftCorner<3, 3>() = to.bottomRightCorner<3, 3>() = R;
  for (int j = 0; j < 3; ++j)
    to.block<3, 1>(3, j) = R * Eigen::Vector3d::Unit(j).cross(at_mm - fit.turned_about_mm);
  const Vector6 sigma = (to * fit.covariance * to.transpose()).diagonal().cwiseSqrt();
  return (sigma.array() < kNoEstimate).select(sigma, Vector6::Constant(kNaN));
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
                      const std::vector<int>& block, int gauss_newton_steps) {
  MeshFit fit;
  fit.n = fit.n_gated = p_mm.size();
  if (p_mm.size() < kFewestPoints) {
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
  const std::vector<Eigen::Vector3d> taken = pick(p_mm, kGaussNewtonPoints);
  if (gauss_newton(*surface, taken, gate_mm, gauss_newton_steps, refined)) {
    T = refined;
    if (const std::optional<Linearised> at = linearise(*surface, taken, gate_mm, T)) {
      fit.covariance = registration_covariance(*at, pick(block, kGaussNewtonPoints));
      fit.turned_about_mm = at->centroid_mm;
    }
  } else
    fit.message = "the registration did not settle: too few points near the surface, or a poor start";
  fill_statistics(*surface, p_mm, gate_mm, T, fit);
  fit.T_object_measured = cad.T_world_object * T;
  fit.usable = fit.n >= kFewestPoints && fit.message.empty();
  if (fit.n < p_mm.size() / 2 && fit.usable)
    fit.message = "less than half of the points lie within the gate of the registered surface";
  return fit;
}

namespace {

/// Writes the registration in the world, and in the object's frame at the middle of its vertices: there the
/// directions that a flat part leaves open do not mix with the others.
void put_pose(const MeshShape& shape, const MeshFit& fit, ObjectFit& row) {
  const Pose T_world_object = shape.T_world_object, T_object_world = T_world_object.inverse();
  const RotTrans rt = rt_from_pose(fit.T_object_measured);
  const Vector6 sigma =
      pose_sigmas(fit, T_object_world * fit.T_object_measured.translation_mm, T_world_object.rotation);
  put(row, "T_object_measured_r_rad", rt.head<3>());
  put(row, "T_object_measured_r_sigma_rad", sigma.head<3>());
  put(row, "T_object_measured_t_mm", rt.tail<3>());
  put(row, "T_object_measured_t_sigma_mm", sigma.tail<3>());
  Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();
  for (const auto& v : shape.mesh->vertices_mm) middle_mm += v.cast<double>();
  middle_mm /= static_cast<double>(shape.mesh->vertices_mm.size());
  const Pose registered = T_object_world * fit.T_object_measured * T_world_object;
  const Vector6 sigma_object = pose_sigmas(fit, registered * middle_mm, Eigen::Matrix3d::Identity());
  put(row, "object_turn_rad", vector_from_rotation(registered.rotation));
  put(row, "object_turn_sigma_rad", sigma_object.head<3>());
  put(row, "object_shift_mm", registered * middle_mm - middle_mm);
  put(row, "object_shift_sigma_mm", sigma_object.tail<3>());
}

}  // namespace

void fit_shape(const MeshShape& shape, const Gated& points, ObjectFit& row) {
  const MeshFit fit = register_mesh(points.p_mm, shape, points.gate_mm, points.block);
  take_summary(fit, row);
  std::vector<double> absolute;
  double sum = 0.0;
  for (const float d : fit.deviation_mm) {
    sum += static_cast<double>(d);
    absolute.push_back(std::abs(static_cast<double>(d)));
  }
  put(row, "rms_all_mm", fit.rms_mm);  // nothing within the gate is left out
  put(row, "mean_mm", sum / static_cast<double>(absolute.size()));
  put(row, "p95_mm", absolute.empty() ? kNaN : lower_quantile(absolute, 0.95));
  put(row, "within_10um", fit.within_10um);
  put_pose(shape, fit, row);
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

Marks marks_mm(const MeshShape& s, const Eigen::Vector3d&) {
  Marks m = (s.T_world_object * s.mesh->vertices_mm.front().cast<double>()).replicate<1, 4>();
  m.rightCols<3>() += kMarksArm_mm * s.T_world_object.rotation;
  return m;
}

}  // namespace fringetwin::measure
