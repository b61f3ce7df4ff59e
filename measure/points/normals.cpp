// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "measure/points/points.hpp"
#include "measure/points/tangent_plane.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kSmallestRadius = 2, kLargestRadius = 6;
constexpr int kFewestNeighbours = 6;
constexpr double kSteepest = 8.0;     ///< depth over lateral step of neighbours on one surface
constexpr double kSlopeNoise = 0.05;  ///< wanted noise of the surface slope

/// Returns the radius of the window, larger for noisier clouds: the slope of a (2r+1)^2 window has the noise
/// sigma / spacing * sqrt(3) / (2 r^2), about.
int window_radius(const PointCloud& cloud, const Image<int>& grid) {
  std::vector<double> spacing, sigma;
  const std::size_t stride = std::max<std::size_t>(1, grid.size() / 20000);
  for (std::size_t i = 0; i + 1 < grid.size(); i += stride) {
    const int a = grid.data[i], b = grid.data[i + 1];
    if (a < 0 || b < 0) continue;
    spacing.push_back((cloud.p_world_mm[a] - cloud.p_world_mm[b]).norm());
    if (!cloud.sigma_mm.empty()) sigma.push_back(static_cast<double>(cloud.sigma_mm[a]));
  }
  const double d = upper_median(spacing), noise = sigma.empty() ? 0.0 : upper_median(sigma);
  if (!(d > 0.0)) return kSmallestRadius;
  const double radius = std::sqrt(noise / d * std::sqrt(3.0) / (2.0 * kSlopeNoise));
  return std::clamp(static_cast<int>(std::ceil(radius)), kSmallestRadius, kLargestRadius);
}

}  // namespace

void estimate_normals(PointCloud& cloud, int width_px, int height_px, const Eigen::Vector3d& viewer_mm) {
  const Image<int> grid = point_grid(cloud, width_px, height_px);
  const int radius = window_radius(cloud, grid);
  cloud.normal_world.assign(cloud.size(), Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < height_px; ++y)
    for (int x = 0; x < width_px; ++x) {
      const int centre = grid(x, y);
      if (centre < 0) continue;
      const Eigen::Vector3d p0 = cloud.p_world_mm[centre];
      const Eigen::Vector3d view = (p0 - viewer_mm).normalized();
      const double noise = cloud.sigma_mm.empty() ? 0.0 : 6.0 * static_cast<double>(cloud.sigma_mm[centre]);
      TangentSums sums;
      for (int j = std::max(0, y - radius); j <= std::min(height_px - 1, y + radius); ++j)
        for (int i = std::max(0, x - radius); i <= std::min(width_px - 1, x + radius); ++i) {
          const int k = grid(i, j);
          if (k < 0) continue;
          const Eigen::Vector3d p = cloud.p_world_mm[k] - p0;
          const double along = view.dot(p);
          const double lateral_sq = std::max(0.0, p.squaredNorm() - along * along);
          if (std::abs(along) > kSteepest * std::sqrt(lateral_sq) + noise) continue;  // behind a jump
          sums.add(i - x, j - y, p);
        }
      if (sums.n() < kFewestNeighbours) continue;
      const std::optional<TangentPlane> plane = sums.plane();
      if (!plane) continue;
      Eigen::Vector3d normal = plane->along_x_mm.cross(plane->along_y_mm);
      const double length = normal.norm();
      if (!(length > 0.0)) continue;
      normal /= normal.dot(view) > 0.0 ? -length : length;
      cloud.normal_world[centre] = normal.cast<float>();
    }
}

}  // namespace fringetwin::measure
