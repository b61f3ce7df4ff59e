// SPDX-License-Identifier: Apache-2.0
// Draws a static picture of a point cloud: orthographic, nearest point wins, coloured by a value.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin::report {

struct CloudView {
  /// Direction of view in the world frame (from the eye to the scene) and the direction shown up.
  Eigen::Vector3d forward_world = Eigen::Vector3d(0.35, 0.30, 1.0);
  Eigen::Vector3d up_world = Eigen::Vector3d(0.0, -1.0, 0.0);  ///< world y points down
  int width_px = 640, height_px = 480;
  int dot_px = 0;                    ///< 0 = just large enough to close the gaps of a dense cloud
  std::size_t max_points = 300'000;  ///< every k-th point is drawn beyond this
};

/// Rows: right, down and away from the eye, unit vectors in the world frame.
Eigen::Matrix3d view_axes(const CloudView& view);

struct CloudPicture {
  ImageF value;  ///< NaN where no point is seen
  double mm_per_px = 0.0;
  std::size_t n_drawn = 0, n_points = 0;
};

/// `value` per point (deviation, height …); points with a non-finite coordinate are left out.
/// The cloud fills the picture up to its 0.1 % and 99.9 % percentiles, so that a stray point does not
/// shrink it.
CloudPicture draw_cloud(const std::vector<Eigen::Vector3d>& p_world_mm, const std::vector<float>& value,
                        const CloudView& view);

/// A bar of a round length (1, 2 or 5 times a power of ten, at most a quarter of the picture's width) with
/// its length in mm, as wide as that length is in a picture shown at its full width. Parallel projection: the
/// bar holds across the line of sight, everywhere in the picture.
std::string scale_bar_html(double mm_per_px, int width_px);

}  // namespace fringetwin::report
