// SPDX-License-Identifier: Apache-2.0
#include "measure/points/depth_solver.hpp"

#include <cmath>

namespace fringetwin::measure {
namespace {

constexpr int kMostSteps = 25;
constexpr double kLongestStepPx = 4.0;     ///< per iteration, in the second image (maps)
constexpr double kLongestStepRatio = 0.3;  ///< of the depth, per iteration
/// A step this short is the last one: Newton leaves about its square times the curvature of the map (1e-2 per
/// px at most) and, where interpolation pieces meet, a thousandth of it.
constexpr double kConvergedPx = 2e-4;
constexpr double kAcceptedPx = 1e-3;  ///< flicker between neighbouring interpolation pieces

struct Equation {
  double residual_px, slope_px_per_mm, sigma_px;
};

struct Step {
  double step_mm, variance_factor;
};

/// Solves weighted least squares for one unknown; equal weights where a noise is unknown.
Step least_squares_step(const Equation* e, int count) {
  if (count == 1) return {-e[0].residual_px / e[0].slope_px_per_mm, std::abs(1.0 / e[0].slope_px_per_mm)};
  const bool weighted = e[0].sigma_px > 0.0 && e[1].sigma_px > 0.0;
  double numerator = 0.0, denominator = 0.0, spread = 0.0;
  for (int k = 0; k < 2; ++k) {
    const double w = weighted ? 1.0 / (e[k].sigma_px * e[k].sigma_px) : 1.0;
    numerator += w * e[k].slope_px_per_mm * e[k].residual_px;
    denominator += w * e[k].slope_px_per_mm * e[k].slope_px_per_mm;
    spread += std::pow(w * e[k].slope_px_per_mm * e[k].sigma_px, 2);
  }
  return {-numerator / denominator, std::sqrt(spread) / denominator};
}

/// `evaluate(q, dq_ds, equations)` fills `count` equations at pixel q, false when it cannot.
template <class Evaluate>
SolveStatus solve(const Lens& lens, const Pose& T, const Eigen::Vector3d& d_cam, int count, double start_mm,
                  double longest_px, const Evaluate& evaluate, DepthSolution& out) {
  const Eigen::Vector3d direction = T.rotation * d_cam;
  double s = start_mm;
  double moved_px = 0.0;
  Eigen::Matrix<double, 2, 3> J;
  Equation equations[2];
  for (int k = 0; k < kMostSteps; ++k) {
    const Eigen::Vector3d p = s * direction + T.translation_mm;
    const auto q = lens.project(p, &J);
    if (!q) return SolveStatus::outside;
    const Eigen::Vector2d dq_ds = J * direction;
    if (!evaluate(*q, dq_ds, equations)) return SolveStatus::outside;
    const Step step = least_squares_step(equations, count);
    const double motion_px = dq_ds.norm();
    double ds = step.step_mm;
    if (!std::isfinite(ds)) return SolveStatus::failed;
    const double limit = std::min(longest_px / motion_px, kLongestStepRatio * s);
    const bool limited = std::abs(ds) > limit;
    if (limited) ds = std::copysign(limit, ds);
    s += ds;
    moved_px = std::abs(ds) * motion_px;
    if (moved_px > kConvergedPx && k + 1 < kMostSteps) continue;
    if (moved_px > kAcceptedPx) break;
    out.depth_mm = s;
    out.p_mm = s * direction + T.translation_mm;
    out.q_px = *q + ds * dq_ds;
    double sum_sq = 0.0;
    for (int j = 0; j < count; ++j)
      sum_sq += std::pow(equations[j].residual_px + ds * equations[j].slope_px_per_mm, 2);
    out.residual_px = count > 1 ? std::sqrt(sum_sq / count) : 0.0;
    out.sigma_mm = count > 1 ? step.variance_factor : step.variance_factor * equations[0].sigma_px;
    return SolveStatus::ok;
  }
  return SolveStatus::failed;
}

}  // namespace

SolveStatus solve_depth_in_maps(const Lens& lens, const Pose& T_device_cam, const Eigen::Vector3d& d_cam,
                                const CoordinateMap* const* maps, const CoordinateTarget* targets, int count,
                                double start_mm, DepthSolution& out) {
  const auto evaluate = [&](const Eigen::Vector2d& q, const Eigen::Vector2d& dq_ds, Equation* equations) {
    for (int k = 0; k < count; ++k) {
      MapSample sample;
      if (!maps[k]->sample(q.x(), q.y(), sample)) return false;
      equations[k] = {sample.value - targets[k].coordinate_px,
                      sample.d_dx * dq_ds.x() + sample.d_dy * dq_ds.y(),
                      std::hypot(targets[k].sigma_px, sample.noise_gain * maps[k]->sigma_px(q.x(), q.y()),
                                 sample.error_px)};
    }
    return true;
  };
  return solve(lens, T_device_cam, d_cam, count, start_mm, kLongestStepPx, evaluate, out);
}

SolveStatus solve_depth_in_projector(const Lens& lens, const Pose& T_device_cam, const Eigen::Vector3d& d_cam,
                                     const int* axes, const CoordinateTarget* targets, int count,
                                     double start_mm, DepthSolution& out) {
  const auto evaluate = [&](const Eigen::Vector2d& q, const Eigen::Vector2d& dq_ds, Equation* equations) {
    for (int k = 0; k < count; ++k)
      equations[k] = {q[axes[k]] - targets[k].coordinate_px, dq_ds[axes[k]], targets[k].sigma_px};
    return true;
  };
  const double anywhere = 0.25 * (lens.width() + lens.height());
  return solve(lens, T_device_cam, d_cam, count, start_mm, anywhere, evaluate, out);
}

}  // namespace fringetwin::measure
