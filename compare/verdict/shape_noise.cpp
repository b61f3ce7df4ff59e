// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/shape_noise.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "measure/depth_fit.hpp"

namespace fringetwin::compare {
namespace {

/// Returns the sum of squares of a kernel's sums over a square that slides over it, over n^4 times its own:
/// the mean over n^2 pixels sees each value of the noise with the kernel's sum over the square.
double share_of(const Eigen::MatrixXd& kernel, int region_px) {
  const Eigen::Index size = kernel.rows(), n = region_px;
  double sum = 0.0;
  for (Eigen::Index y = 1 - n; y < size; ++y)
    for (Eigen::Index x = 1 - n; x < size; ++x) {
      const Eigen::Index x0 = std::max<Eigen::Index>(x, 0), y0 = std::max<Eigen::Index>(y, 0);
      const Eigen::Index w = std::min(x + n, size) - x0, h = std::min(y + n, size) - y0;
      const double s = kernel.block(y0, x0, h, w).sum();
      sum += s * s;
    }
  return sum / (std::pow(static_cast<double>(n), 4) * kernel.squaredNorm());
}

}  // namespace

Eigen::Vector2d depth_direction(const Twin& twin, std::size_t camera) {
  // An epipolar line is one for all depths: the first that both devices see tells it.
  constexpr double kBaselines[] = {10.0, 5.0, 3.0, 2.0, 1.5, 1.0}, kFurther = 1.001;
  Eigen::Vector2d has_fringes = Eigen::Vector2d::Zero();
  for (const DirectionFringes& d : twin.fringes.directions) has_fringes[d.axis == Axis::x ? 0 : 1] = 1.0;
  const Eigen::Vector2d first = has_fringes.x() > 0.0 ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
  if (!twin.projector) return first;
  const Camera& c = twin.cameras.at(camera);
  const auto ray = c.lens.unproject({0.5 * (c.lens.width() - 1), 0.5 * (c.lens.height() - 1)});
  if (!ray) return first;
  const Pose T_proj_cam = twin.projector->T_proj_world * c.T_cam_world.inverse();
  for (const double baselines : kBaselines) {
    const Eigen::Vector3d p_mm = baselines * T_proj_cam.translation_mm.norm() * *ray;
    const auto near_px = twin.projector->lens.project(T_proj_cam * p_mm),
               far_px = twin.projector->lens.project(T_proj_cam * Eigen::Vector3d(kFurther * p_mm));
    if (!near_px || !far_px) continue;
    const Eigen::Vector2d along = (*far_px - *near_px).cwiseProduct(has_fringes);
    return along.norm() > 0.0 ? Eigen::Vector2d(along.normalized()) : first;
  }
  return first;
}

RegionShares region_shares(double radius_px, int region_px) {
  const double alone = 1.0 / (static_cast<double>(region_px) * region_px);
  const auto window = measure::window_of(std::max(0.0, std::floor(radius_px + 0.5)));
  if (window.size() < static_cast<std::size_t>(measure::kQuadraticPoints)) return {alone, alone};
  Eigen::MatrixXd design(static_cast<Eigen::Index>(window.size()), 6);
  for (std::size_t k = 0; k < window.size(); ++k) {
    const double x = window[k].dx, y = window[k].dy;
    design.row(static_cast<Eigen::Index>(k)) << 1.0, x, y, x * x, x * y, y * y;
  }
  const Eigen::Matrix<double, 6, 6> inverse = (design.transpose() * design).inverse();
  const Eigen::MatrixXd response = design * inverse.leftCols<2>();  // of the value and of the slope along x
  const auto r = static_cast<Eigen::Index>(std::lround(radius_px));
  Eigen::MatrixXd depth = Eigen::MatrixXd::Zero(2 * r + 1, 2 * r + 1), slope = depth;
  for (std::size_t k = 0; k < window.size(); ++k) {
    depth(window[k].dy + r, window[k].dx + r) = response(static_cast<Eigen::Index>(k), 0);
    slope(window[k].dy + r, window[k].dx + r) = response(static_cast<Eigen::Index>(k), 1);
  }
  return {share_of(depth, region_px), share_of(slope, region_px)};
}

}  // namespace fringetwin::compare
