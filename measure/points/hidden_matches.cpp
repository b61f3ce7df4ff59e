// SPDX-License-Identifier: Apache-2.0
#include "measure/points/hidden_matches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "measure/points/tangent_plane.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::measure {
namespace {

constexpr int kWindowRadius = 3;         ///< of the neighbours whose plane is fitted, px of camera 0
constexpr int kFewestOfWindow = 12;      ///< of 49; fewer say nothing of a slope
constexpr double kEdgeOnCosine = 0.124;  ///< 82.9 degrees from the normal
/// Of the cosine to camera 0, and of the sine between the rays to both cameras, which that cosine is on a
/// slide: the planes that a step along the baseline or a round edge makes are steep to both.
constexpr double kFlatterThanSeen = 0.5, kLeastOfSlide = 0.3;
constexpr double kSlopeSigmas = 3.0;
constexpr double kSuspectCosine = 0.4;  ///< of the chords over a pixel, above which no plane is fitted

/// How a plane lies to both cameras.
struct Attitude {
  double cosine0 = kNaN, cosine1 = kNaN;  ///< between the normal on the side that camera 0 sees and each ray
  double cosine1_sigma = 0.0;
  double sine_between = kNaN;  ///< of the angle between the rays
};

bool is_known(const Eigen::Vector3d& p_mm) { return std::isfinite(p_mm.z()); }

/// Noise moves slopes along the ray of camera 0: that changes the area that camera 1 sees, not that of camera
/// 0.
Attitude attitude(const TangentPlane& plane, double sigma_mm, const Eigen::Vector3d& center1_cam0_mm) {
  const Eigen::Vector3d to0 = -plane.at_mm.normalized(), to1 = (center1_cam0_mm - plane.at_mm).normalized();
  const Eigen::Vector3d area = plane.along_x_mm.cross(plane.along_y_mm);
  const double size = std::copysign(area.norm(), area.dot(to0));
  const double by_x = to0.cross(plane.along_y_mm).dot(to1) * plane.noise_x,
               by_y = plane.along_x_mm.cross(to0).dot(to1) * plane.noise_y;
  return {area.dot(to0) / size, area.dot(to1) / size, sigma_mm * std::hypot(by_x, by_y) / std::abs(size),
          to0.cross(to1).norm()};
}

bool is_edge_on(const Attitude& a) {
  return a.cosine1 + kSlopeSigmas * a.cosine1_sigma < kEdgeOnCosine &&
         a.cosine1 < kFlatterThanSeen * a.cosine0 && a.cosine0 > kLeastOfSlide * a.sine_between;
}

/// Returns the chords over a pixel, as long as its neighbours reach on both sides; NaN without them.
TangentPlane chords(const Image<Eigen::Vector3d>& points, int x, int y) {
  const auto chord = [&](int dx, int dy) -> Eigen::Vector3d {
    for (int r = kWindowRadius; r > 0; --r) {
      const int x0 = x - r * dx, x1 = x + r * dx, y0 = y - r * dy, y1 = y + r * dy;
      if (x0 < 0 || y0 < 0 || x1 >= points.width || y1 >= points.height) continue;
      if (is_known(points(x0, y0)) && is_known(points(x1, y1))) return points(x1, y1) - points(x0, y0);
    }
    return Eigen::Vector3d::Constant(kNaN);
  };
  return {points(x, y), chord(1, 0), chord(0, 1)};
}

/// Returns the plane of the neighbours; nothing with too few, or all in a line.
std::optional<TangentPlane> plane_about(const Image<Eigen::Vector3d>& points, int x, int y) {
  TangentSums sums;
  for (int v = std::max(0, y - kWindowRadius); v <= std::min(points.height - 1, y + kWindowRadius); ++v)
    for (int u = std::max(0, x - kWindowRadius); u <= std::min(points.width - 1, x + kWindowRadius); ++u)
      if (is_known(points(u, v))) sums.add(u - x, v - y, points(u, v) - points(x, y));
  if (sums.n() < kFewestOfWindow) return std::nullopt;
  std::optional<TangentPlane> plane = sums.plane();
  if (plane) plane->at_mm += points(x, y);
  return plane;
}

ImageU8 edge_on_points(const Image<Eigen::Vector3d>& points, const ImageF& sigma_mm,
                       const Eigen::Vector3d& center1_cam0_mm) {
  ImageU8 edge_on(points.width, points.height, 0);
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < points.height; ++y)
    for (int x = 0; x < points.width; ++x) {
      if (!is_known(points(x, y))) continue;
      if (attitude(chords(points, x, y), 0.0, center1_cam0_mm).cosine1 > kSuspectCosine) continue;
      const std::optional<TangentPlane> plane = plane_about(points, x, y);
      edge_on(x, y) =
          plane && is_edge_on(attitude(*plane, static_cast<double>(sigma_mm(x, y)), center1_cam0_mm));
    }
  return edge_on;
}

}  // namespace

ImageU8 hidden_matches(const Image<Eigen::Vector3d>& p_cam0_mm, const ImageF& sigma_mm,
                       const Eigen::Vector3d& center1_cam0_mm, double step1) {
  const int width = p_cam0_mm.width, height = p_cam0_mm.height;
  const ImageU8 edge_on = edge_on_points(p_cam0_mm, sigma_mm, center1_cam0_mm);
  const auto ray1 = [&](int x, int y) -> Eigen::Vector3d {
    return (p_cam0_mm(x, y) - center1_cam0_mm).normalized();
  };
  ImageU8 hidden = edge_on;
  // what meets in the same pixel of camera 1 is part of the same jump
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (edge_on(x, y) == 0) continue;
      const Eigen::Vector3d ray = ray1(x, y);
      for (int v = std::max(0, y - kWindowRadius); v <= std::min(height - 1, y + kWindowRadius); ++v)
        for (int u = std::max(0, x - kWindowRadius); u <= std::min(width - 1, x + kWindowRadius); ++u)
          if (is_known(p_cam0_mm(u, v)) && (ray1(u, v) - ray).norm() <= step1) hidden(u, v) = 1;
    }
  return hidden;
}

}  // namespace fringetwin::measure
