// SPDX-License-Identifier: Apache-2.0
#include "measure/points/point_rows.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace fringetwin::measure {

void PointRow::add(const Eigen::Vector2d& q_px, const Eigen::Vector3d& p_mm, double sigma,
                   double residual_px) {
  p_cam_mm.push_back(p_mm);
  q_cam_px.push_back(q_px.cast<float>());
  sigma_mm.push_back(static_cast<float>(sigma));
  residual_sum_sq += residual_px * residual_px;
}

PointCloud join_rows(std::vector<PointRow> rows, const Pose& T_world_cam, TriangulationSummary* summary) {
  std::size_t n = 0;
  for (const PointRow& row : rows) n += row.p_cam_mm.size();
  PointCloud cloud;
  cloud.p_world_mm.reserve(n);
  cloud.q_cam_px.reserve(n);
  cloud.sigma_mm.reserve(n);
  TriangulationSummary total;
  double residual_sum_sq = 0.0;
  for (PointRow& each : rows) {
    const PointRow row = std::move(each);  // freed as soon as it is joined
    for (const Eigen::Vector3d& p : row.p_cam_mm) cloud.p_world_mm.push_back(T_world_cam * p);
    cloud.q_cam_px.insert(cloud.q_cam_px.end(), row.q_cam_px.begin(), row.q_cam_px.end());
    cloud.sigma_mm.insert(cloud.sigma_mm.end(), row.sigma_mm.begin(), row.sigma_mm.end());
    total.n_candidates += row.summary.n_candidates;
    total.n_no_match += row.summary.n_no_match;
    total.n_ambiguous += row.summary.n_ambiguous;
    total.n_rejected += row.summary.n_rejected;
    total.n_too_uncertain += row.summary.n_too_uncertain;
    residual_sum_sq += row.residual_sum_sq;
  }
  total.n_points = n;
  total.residual_rms_px = n ? std::sqrt(residual_sum_sq / static_cast<double>(n)) : 0.0;
  cloud.normal_world.assign(n, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  if (summary) *summary = total;
  return cloud;
}

double coordinate_sigma(const DirectionDecode& direction, int x, int y) {
  if (direction.coordinate_sigma_px.empty()) return 0.0;
  const double s = static_cast<double>(direction.coordinate_sigma_px(x, y));
  return std::isfinite(s) ? s : 0.0;
}

}  // namespace fringetwin::measure
