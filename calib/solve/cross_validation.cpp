// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/cross_validation.hpp"

#include <algorithm>
#include <cmath>

#include "calib/solve/calibrate.hpp"
#include "calib/solve/triangulate.hpp"
#include "calib/solve/uncertainty.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::calib {
namespace {

struct GridPoint {
  int column = 0, row = 0;
  Eigen::Vector2d q_px;
  Eigen::Vector3d p_a_mm;    ///< in the device's frame of calibration a
  double expected_px = 1.0;  ///< sigma of the difference
};

/// Gauss-Newton for the rigid motion that makes b project the points where a does. Weighted by what is
/// expected: else the far corners, which no board reached, would turn the well-known centre.
Pose implied_motion(const Lens& b, const std::vector<GridPoint>& points) {
  Pose T;
  constexpr int kSteps = 30;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (const GridPoint& g : points) {
      const Eigen::Vector3d p = T * g.p_a_mm;
      Eigen::Matrix<double, 2, 3> dq;
      const auto q = b.project(p, &dq);
      if (!q) continue;
      Eigen::Matrix<double, 3, 6> dp;  // a small turn after T, then a shift
      dp << 0, p.z(), -p.y(), 1, 0, 0, -p.z(), 0, p.x(), 0, 1, 0, p.y(), -p.x(), 0, 0, 0, 1;
      const Eigen::Matrix<double, 2, 6> J = dq * dp;
      const double weight = 1.0 / (g.expected_px * g.expected_px);
      normal += weight * J.transpose() * J;
      right += weight * J.transpose() * (g.q_px - *q);
    }
    const Eigen::Matrix<double, 6, 1> move = solve_symmetric(normal, right);
    if (!move.allFinite()) break;
    T = Pose{rotation_from_vector(move.head<3>()), move.tail<3>()} * T;
    if (move.norm() < 1e-12) break;
  }
  return T;
}

Observations without_outliers(const Calibration& c) {
  Observations o = c.observations;
  for (std::size_t v = 0; v < o.views.size(); ++v)
    for (std::size_t i = 0; i < o.views[v].corners.size(); ++i)
      if (c.is_outlier(v, i)) o.views[v].corners[i].weight = -1.0;
  return o;
}

double shape_difference_mm(const Calibration& a, const Calibration& b) {
  if (a.devices.size() < 2) return std::nan("");
  std::vector<Lens> lens_a, lens_b;
  std::vector<Pose> T_a, T_b;
  for (std::size_t d = 0; d < a.devices.size(); ++d) {
    lens_a.push_back(a.lens(static_cast<int>(d)));
    lens_b.push_back(b.lens(static_cast<int>(d)));
    T_a.push_back(a.devices[d].T_device_ref);
    T_b.push_back(b.devices[d].T_device_ref);
  }
  // Where the boards were.
  std::vector<Eigen::Vector3d> in_a, in_b;
  for (std::size_t f = 0; f < a.observations.frames.size(); ++f) {
    const Pose T = T_ref_board(a.problem, static_cast<int>(f));
    for (std::size_t i = 0; i < a.observations.board.corners(); i += 3) {
      const Eigen::Vector3d p = T * a.observations.board.point_mm(i, a.warp_mm);
      std::vector<Eigen::Vector2d> q;
      for (std::size_t d = 0; d < lens_a.size(); ++d)
        if (const auto at = lens_a[d].project(T_a[d] * p)) q.push_back(*at);
      if (q.size() != lens_a.size()) continue;
      const auto again = triangulate(lens_b, T_b, q, p);
      if (!again) continue;
      in_a.push_back(p);
      in_b.push_back(*again);
    }
  }
  return in_a.size() < 3 ? std::nan("") : aligned_rms_mm(in_a, in_b);
}

}  // namespace

ProjectionDifference projection_difference(const Calibration& a, const Calibration& b, int device,
                                           double distance_mm, int columns) {
  const Lens from = a.lens(device), to = b.lens(device);
  const int rows =
      std::max(2, static_cast<int>(std::lround(static_cast<double>(columns) * from.height() / from.width())));
  ProjectionDifference out;
  out.difference_px = out.expected_px = ImageF(columns, rows, std::nanf(""));
  std::vector<GridPoint> points;
  const Uncertainty ua(a), ub(b);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector2d q((from.width() - 1.0) * c / (columns - 1),
                              (from.height() - 1.0) * r / (rows - 1));
      const auto v = from.unproject(q);
      if (!v || v->z() <= 0.0) continue;
      const Eigen::Vector3d p = *v * (distance_mm / v->z());
      if (!to.project(p)) continue;
      // The motion is small, so b's uncertainty may be taken at the same place.
      const double expected = worst_direction_sigma(ua.projection(device, p) + ub.projection(device, p));
      points.push_back({c, r, q, p, expected});
    }
  const Pose T = implied_motion(to, points);
  double sum = 0.0, ratio = 0.0;
  int n = 0;
  for (const GridPoint& g : points) {
    const auto q = to.project(T * g.p_a_mm);
    if (!q) continue;
    const double difference = (*q - g.q_px).norm();
    out.difference_px(g.column, g.row) = static_cast<float>(difference);
    out.expected_px(g.column, g.row) = static_cast<float>(g.expected_px);
    out.max_px = std::max(out.max_px, difference);
    sum += difference * difference;
    ratio += std::pow(difference / g.expected_px, 2);
    ++n;
  }
  out.rms_px = std::sqrt(sum / std::max(n, 1));
  out.relative = std::sqrt(ratio / std::max(n, 1));
  return out;
}

CrossValidation cross_validate(const Calibration& whole, const CalibrateOptions& options) {
  CrossValidation out;
  out.shape_rms_mm = std::nan("");
  const Observations all = without_outliers(whole);
  std::vector<int> even, odd;
  for (int f = 0; f < static_cast<int>(all.frames.size()); ++f) (f % 2 == 0 ? even : odd).push_back(f);
  out.n_even = static_cast<int>(even.size());
  out.n_odd = static_cast<int>(odd.size());
  CalibrateOptions once = options;
  once.reject_outliers = false;
  once.outlier_sigmas = {5.0};
  try {
    const Calibration a = calibrate(select_frames(all, even), once),
                      b = calibrate(select_frames(all, odd), once);
    for (std::size_t d = 0; d < whole.devices.size(); ++d)
      out.devices.push_back(
          projection_difference(a, b, static_cast<int>(d), whole.working_distance_mm(static_cast<int>(d))));
    out.shape_rms_mm = shape_difference_mm(a, b);
  } catch (const UserError& e) {
    out.devices.clear();
    out.not_done = std::string("half of the views cannot be calibrated alone: ") + e.what();
  }
  return out;
}

}  // namespace fringetwin::calib
