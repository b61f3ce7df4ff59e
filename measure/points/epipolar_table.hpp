// SPDX-License-Identifier: Apache-2.0
// Tells where in the second image to start looking for a match: its pixels sorted by epipolar plane and
// coordinate.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "measure/points/coordinate_map.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::measure {

/// Bins (angle of the epipolar plane x coordinate) of the second camera's pixels. An entry stands
/// for the step from a pixel to its neighbour along the epipolar curve and fills all the bins that the
/// coordinate passes on the way, so that coarse maps leave no holes.
class EpipolarTable {
 public:
  static constexpr int kMostCandidates = 8;

  EpipolarTable(const Lens& lens, const Pose& T_cam1_cam0, const CoordinateMap& map);
  /// Finds the depths along the unit ray `d` of camera 0 at which camera 1 saw about `coordinate_px`; one per
  /// place in the image. Returns how many (<= kMostCandidates).
  int candidates(const Eigen::Vector3d& d_cam0, double coordinate_px, double* depth_mm) const;

 private:
  double angle(const Eigen::Vector3d& d_cam0) const;
  Eigen::Vector3d coarse_ray_cam0(double x, double y) const;
  double coarse_angle(int x, int y) const;
  int collect(int angle_bin, int value_bin, const Eigen::Vector3d& d_cam0, double coordinate_px,
              Eigen::Vector2d* places, double* depth_mm, int count) const;
  void set_coarse_rays(const Lens& lens);
  void set_bins();
  template <class Visit>
  void visit_steps(Visit visit) const;

  const ImageD& map_;
  Eigen::Matrix3d rotation_cam0_cam1_;
  Eigen::Vector3d center1_cam0_mm_, e1_, e2_;
  int step_x_ = 1, step_y_ = 0;  ///< neighbour along the epipolar curve
  int grid_width_ = 0, grid_height_ = 0;
  std::vector<Eigen::Vector3d> grid_rays_;
  std::vector<double> grid_angles_;
  double angle_low_ = 0.0, angle_width_ = 1.0, value_low_ = 0.0, value_width_ = 1.0;
  int angle_bins_ = 0, value_bins_ = 0;
  std::vector<std::uint32_t> first_;   ///< per bin, plus the end
  std::vector<std::uint32_t> pixels_;  ///< index of the step's first pixel
};

}  // namespace fringetwin::measure
