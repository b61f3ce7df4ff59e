// SPDX-License-Identifier: Apache-2.0
#include "calib/page/calibration_findings.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/solve/uncertainty.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kGridColumns = 32;
constexpr std::size_t kMostShapePoints = 60;

/// Returns the worst-direction sigma, px, of where a device sees the point that pixel q shows at this
/// distance or at infinity; NaN where the lens has no ray.
double sigma_at(const Uncertainty& u, const Lens& lens, int device, const Eigen::Vector2d& q,
                double distance_mm, bool at_infinity) {
  const auto v = lens.unproject(q);
  if (!v || v->z() <= 0.0) return std::nan("");
  return worst_direction_sigma(at_infinity ? u.projection_at_infinity(device, *v)
                                           : u.projection(device, *v * (distance_mm / v->z())));
}

DeviceFindings about_device(const Calibration& c, const Uncertainty& u, int device) {
  DeviceFindings out;
  const Lens lens = c.lens(device);
  const double w = lens.width() - 1.0, h = lens.height() - 1.0;
  out.distance_mm = c.working_distance_mm(device);
  const auto at = [&](double x, double y) {
    return sigma_at(u, lens, device, {x, y}, out.distance_mm, false);
  };
  out.centre_sigma_px = at(0.5 * w, 0.5 * h);
  out.corner_sigma_px = {at(0, 0), at(w, 0), at(0, h), at(w, h)};
  out.centre_at_infinity_sigma_px = sigma_at(u, lens, device, {0.5 * w, 0.5 * h}, out.distance_mm, true);
  const int rows = std::max(2, static_cast<int>(std::lround(kGridColumns * (h + 1.0) / (w + 1.0))));
  out.sigma_px = ImageF(kGridColumns, rows, std::nanf(""));
  for (int r = 0; r < rows; ++r)
    for (int k = 0; k < kGridColumns; ++k)  // cell centres
      out.sigma_px(k, r) = static_cast<float>(
          at((k + 0.5) / kGridColumns * (w + 1.0) - 0.5, (r + 0.5) / rows * (h + 1.0) - 0.5));
  const Eigen::MatrixXd lens_covariance = u.intrinsics(device);
  const std::size_t n = lens.intrinsics().size(),
                    fixed = n - static_cast<std::size_t>(lens_covariance.rows());
  out.intrinsics_sigma.assign(n, std::nan(""));
  for (std::size_t i = fixed; i < n; ++i) {
    const auto k = static_cast<Eigen::Index>(i - fixed);
    out.intrinsics_sigma[i] = std::sqrt(lens_covariance(k, k));
  }
  if (device > 0) out.rt_sigma = u.extrinsics(device).diagonal().cwiseSqrt();
  return out;
}

/// Returns the four outermost corners and the middle corner of the boards in the reference frame, mm; of
/// every k-th board only, so that there are few enough points for their joint covariance.
std::vector<Eigen::Vector3d> points_of_boards(const Calibration& c) {
  const Board& board = c.observations.board;
  const auto width = static_cast<std::size_t>(board.width_n);
  const std::array<std::size_t, 5> on_board{
      0, width - 1, board.corners() - width, board.corners() - 1,
      board.corners() / 2 + width / 2 * (static_cast<std::size_t>(board.height_n + 1) % 2)};
  const std::size_t frames = c.observations.frames.size();
  const std::size_t step = 1 + frames * on_board.size() / kMostShapePoints;
  std::vector<Eigen::Vector3d> points;
  for (std::size_t f = 0; f < frames; f += step)
    for (const std::size_t i : on_board)
      points.push_back(T_ref_board(c.problem, static_cast<int>(f)) *
                       board.point_mm(std::min(i, board.corners() - 1), c.warp_mm));
  return points;
}

PairFindings about_pair(const Calibration& c, const Uncertainty& u, int first, int second) {
  PairFindings out{.first = first, .second = second, .shape_sigma_mm = std::nan("")};
  const auto pose = [&](int d) { return c.devices[d].T_device_ref; };
  out.baseline_mm = (pose(first) * pose(second).inverse()).translation_mm.norm();
  out.baseline_sigma_mm = u.baseline_sigma_mm(first, second);
  std::vector<Eigen::Vector3d> points;
  for (const auto& p : points_of_boards(c))
    if (c.lens(first).project(pose(first) * p) && c.lens(second).project(pose(second) * p))
      points.push_back(p);
  if (points.size() >= 3)
    out.shape_sigma_mm = aligned_shape_sigma_mm(points, u.points(points, {{first}, {second}}));
  return out;
}

}  // namespace

Findings calibration_findings(const Calibration& c, const CalibrateOptions& options) {
  Findings out;
  const Uncertainty u(c);
  out.observed_sigma_px = u.observed_sigma_px();
  out.shared_noise = u.shared();
  out.warp_sigma_mm = u.warp().diagonal().cwiseSqrt();
  constexpr std::size_t kMostParameters = 16;
  if (c.devices[0].intrinsics.size() <= kMostParameters) out.rig_covariance = u.rig();
  const int n = static_cast<int>(c.devices.size());
  for (int d = 0; d < n; ++d) out.devices.push_back(about_device(c, u, d));
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) out.pairs.push_back(about_pair(c, u, a, b));
  out.cross_validation = cross_validate(c, options);
  return out;
}

std::vector<std::string> summary_lines(const Calibration& c) {
  const int n = c.fit.n_corners + c.fit.n_outliers;
  return {
      fmt::format("RMS reprojection error: {:.4f} pixels per coordinate, {:.4f} pixels per corner (2-norm)",
                  c.fit.rms_component_px, c.fit.rms_px),
      fmt::format("Worst residual (by corner): {:.3f} pixels", c.fit.worst_px),
      fmt::format("Noutliers: {} out of {} corners: {:.1f}% of the data", c.fit.n_outliers, n,
                  100.0 * c.fit.n_outliers / n),
      fmt::format("calobject_warp: {:.6g} {:.6g} m", c.problem.warp_m.x(), c.problem.warp_m.y())};
}

}  // namespace fringetwin::calib
