// SPDX-License-Identifier: Apache-2.0
// Collects the points of each image row, found by one thread, and joins them in row order, so that the cloud
// does not depend on the number of threads.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "measure/points/points.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::measure {

struct PointRow {
  std::vector<Eigen::Vector3d> p_cam_mm;
  std::vector<Eigen::Vector2f> q_cam_px;
  std::vector<float> sigma_mm;
  TriangulationSummary summary;
  double residual_sum_sq = 0.0;

  void add(const Eigen::Vector2d& q_px, const Eigen::Vector3d& p_mm, double sigma, double residual_px);
};

PointCloud join_rows(std::vector<PointRow> rows, const Pose& T_world_cam, TriangulationSummary* summary);

/// Returns the noise of a decoded coordinate, 0 where unknown.
double coordinate_sigma(const DirectionDecode& direction, int x, int y);

}  // namespace fringetwin::measure
