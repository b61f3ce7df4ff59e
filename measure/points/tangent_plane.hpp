// SPDX-License-Identifier: Apache-2.0
// Fits the plane of points about a pixel over the pixel grid.
#pragma once
#include <Eigen/Core>
#include <optional>

namespace fringetwin::measure {

/// A plane by its point at a pixel and its change from pixel to pixel. The slopes have `noise_x` and
/// `noise_y` times the noise of single points, where that is independent.
struct TangentPlane {
  Eigen::Vector3d at_mm, along_x_mm, along_y_mm;
  double noise_x = 0.0, noise_y = 0.0;
};

/// Sums up points for the least squares of p = at + u along_x + v along_y, (u, v) from the pixel.
class TangentSums {
 public:
  void add(double u, double v, const Eigen::Vector3d& p_mm) {
    n_ += 1;
    u_ += u, v_ += v;
    uu_ += u * u, uv_ += u * v, vv_ += v * v;
    p_ += p_mm, up_ += u * p_mm, vp_ += v * p_mm;
  }
  double n() const { return n_; }
  /// Returns nothing where all points lie in one line of the grid.
  std::optional<TangentPlane> plane() const;

 private:
  double n_ = 0, u_ = 0, v_ = 0, uu_ = 0, uv_ = 0, vv_ = 0;
  Eigen::Vector3d p_ = Eigen::Vector3d::Zero(), up_ = Eigen::Vector3d::Zero(), vp_ = Eigen::Vector3d::Zero();
};

}  // namespace fringetwin::measure
