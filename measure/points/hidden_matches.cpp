// SPDX-License-Identifier: Apache-2.0
#include "measure/points/hidden_matches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace fringetwin::measure {
namespace {

constexpr int kWindowRadius = 3;             ///< radius of the neighbourhood whose plane is fitted, px of camera 0
constexpr int kFewestOfWindow = 12;      ///< of the 49 of a window; fewer say nothing of a slope
constexpr double kEdgeOnCosine = 0.124;  ///< 82.9 degrees from the normal: a depth over lateral step of 8
constexpr double kSuspectCosine = 0.4;   ///< of the chords across a pixel, beyond which no plane is fitted

struct Slopes {
  Eigen::Vector3d middle_mm, along_x_mm, along_y_mm;  ///< of the plane; per px
};

bool known(const Eigen::Vector3d& p_mm) { return std::isfinite(p_mm.z()); }

/// Returns the cosine between the plane's normal, on the side that camera 0 sees, and the ray to camera 1.
double cosine_seen(const Slopes& plane, const Eigen::Vector3d& center1_cam0_mm) {
  Eigen::Vector3d normal = plane.along_x_mm.cross(plane.along_y_mm).normalized();
  if (normal.dot(plane.middle_mm) > 0.0) normal = -normal;
  return normal.dot((center1_cam0_mm - plane.middle_mm).normalized());
}

/// Returns the chords across a pixel, as long as its neighbours reach on both sides; NaN without them.
Slopes chords(const Image<Eigen::Vector3d>& points, int x, int y) {
  const auto chord = [&](int dx, int dy) -> Eigen::Vector3d {
    for (int r = kWindowRadius; r > 0; --r) {
      const int x0 = x - r * dx, x1 = x + r * dx, y0 = y - r * dy, y1 = y + r * dy;
      if (x0 < 0 || y0 < 0 || x1 >= points.width || y1 >= points.height) continue;
      if (known(points(x0, y0)) && known(points(x1, y1))) return points(x1, y1) - points(x0, y0);
    }
    return Eigen::Vector3d::Constant(std::nan(""));
  };
  return {points(x, y), chord(1, 0), chord(0, 1)};
}

/// Fits a plane to the neighbours by least squares, each coordinate linear in the pixel. Returns false with too few.
bool fit_plane(const Image<Eigen::Vector3d>& points, int x, int y, Slopes& plane) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), right = Eigen::Matrix3d::Zero();
  for (int v = std::max(0, y - kWindowRadius); v <= std::min(points.height - 1, y + kWindowRadius); ++v)
    for (int u = std::max(0, x - kWindowRadius); u <= std::min(points.width - 1, x + kWindowRadius); ++u) {
      if (!known(points(u, v))) continue;
      const Eigen::Vector3d terms(1.0, u - x, v - y);
      normal.noalias() += terms * terms.transpose();
      right.noalias() += terms * (points(u, v) - points(x, y)).transpose();
    }
  if (normal(0, 0) < kFewestOfWindow || !(normal.determinant() > 1.0)) return false;
  const Eigen::Matrix3d fit = normal.inverse() * right;
  plane = {points(x, y) + fit.row(0).transpose(), fit.row(1).transpose(), fit.row(2).transpose()};
  return true;
}

}  // namespace

Image<unsigned char> hidden_matches(const Image<Eigen::Vector3d>& p_cam0_mm,
                                    const Eigen::Vector3d& center1_cam0_mm, double step1) {
  const int width = p_cam0_mm.width, height = p_cam0_mm.height;
  Image<unsigned char> edge_on(width, height, 0), hidden(width, height, 0);
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!known(p_cam0_mm(x, y))) continue;
      if (cosine_seen(chords(p_cam0_mm, x, y), center1_cam0_mm) > kSuspectCosine) continue;
      Slopes plane;
      if (!fit_plane(p_cam0_mm, x, y, plane)) continue;
      edge_on(x, y) = cosine_seen(plane, center1_cam0_mm) < kEdgeOnCosine;
    }
  // What meets in the same pixel of camera 1 as an edge-on point is part of the same jump.
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!known(p_cam0_mm(x, y))) continue;
      const Eigen::Vector3d ray = (p_cam0_mm(x, y) - center1_cam0_mm).normalized();
      for (int v = std::max(0, y - kWindowRadius); v <= std::min(height - 1, y + kWindowRadius) && !hidden(x, y); ++v)
        for (int u = std::max(0, x - kWindowRadius); u <= std::min(width - 1, x + kWindowRadius) && !hidden(x, y); ++u)
          hidden(x, y) =
              edge_on(u, v) && ((p_cam0_mm(u, v) - center1_cam0_mm).normalized() - ray).norm() <= step1;
    }
  return hidden;
}

}  // namespace fringetwin::measure
