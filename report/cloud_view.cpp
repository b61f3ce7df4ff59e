// SPDX-License-Identifier: Apache-2.0
#include "report/cloud_view.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "report/map.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report {
namespace {

struct Dot {
  float right_mm, down_mm, depth_mm, value;
};

std::vector<Dot> to_view(const std::vector<Eigen::Vector3d>& points, const std::vector<float>& value,
                         const CloudView& view) {
  const Eigen::Matrix3d axes = view_axes(view);
  const Eigen::Vector3d right = axes.row(0), down = axes.row(1), forward = axes.row(2);
  const std::size_t stride =
      std::max<std::size_t>(1, (points.size() + view.max_points - 1) / view.max_points);
  std::vector<Dot> dots;
  dots.reserve(points.size() / stride + 1);
  for (std::size_t i = 0; i < points.size(); i += stride)
    if (points[i].allFinite())
      dots.push_back({static_cast<float>(right.dot(points[i])), static_cast<float>(down.dot(points[i])),
                      static_cast<float>(forward.dot(points[i])), value[i]});
  return dots;
}

MapLimits extent(const std::vector<Dot>& dots, float Dot::*coordinate) {
  std::vector<float> v;
  v.reserve(dots.size());
  for (const Dot& d : dots) v.push_back(d.*coordinate);
  return {percentile(v, 0.1), percentile(v, 99.9)};
}

/// Twice the mean spacing of n points over an area: gaps close, single points do not blow up.
int closing_dot_px(double area_px, std::size_t n) {
  return std::clamp(static_cast<int>(std::ceil(2.0 * std::sqrt(area_px / static_cast<double>(n)))), 1, 7);
}

}  // namespace

Eigen::Matrix3d view_axes(const CloudView& view) {
  const Eigen::Vector3d forward = view.forward_world.normalized();
  const Eigen::Vector3d right = forward.cross(view.up_world).normalized();
  Eigen::Matrix3d axes;
  axes << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  return axes;
}

CloudPicture draw_cloud(const std::vector<Eigen::Vector3d>& p_world_mm, const std::vector<float>& value,
                        const CloudView& view) {
  FT_CHECK(p_world_mm.size() == value.size(), "one value per point");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CloudPicture picture{ImageF(view.width_px, view.height_px, nan), 0.0, 0, p_world_mm.size()};
  const std::vector<Dot> dots = to_view(p_world_mm, value, view);
  picture.n_drawn = dots.size();
  if (dots.empty()) return picture;
  const MapLimits u = extent(dots, &Dot::right_mm), v = extent(dots, &Dot::down_mm);
  const double margin = 0.94;
  picture.mm_per_px = std::max(
      {(u.high - u.low) / (margin * view.width_px), (v.high - v.low) / (margin * view.height_px), 1e-9});
  const double area_px = (u.high - u.low) * (v.high - v.low) / (picture.mm_per_px * picture.mm_per_px);
  const int dot_px = view.dot_px > 0 ? view.dot_px : closing_dot_px(area_px, dots.size());
  // Within a few pixels' worth of depth the first point stays: always taking the nearest would pick the
  // outward half of the noise.
  const float same_surface_mm = static_cast<float>(4.0 * picture.mm_per_px);
  ImageF depth(view.width_px, view.height_px, std::numeric_limits<float>::infinity());
  for (const Dot& d : dots) {
    const double px = (static_cast<double>(d.right_mm) - 0.5 * (u.low + u.high)) / picture.mm_per_px;
    const double py = (static_cast<double>(d.down_mm) - 0.5 * (v.low + v.high)) / picture.mm_per_px;
    const int x0 = static_cast<int>(std::lround(px + 0.5 * view.width_px));
    const int y0 = static_cast<int>(std::lround(py + 0.5 * view.height_px));
    for (int y = std::max(0, y0); y < std::min(view.height_px, y0 + dot_px); ++y)
      for (int x = std::max(0, x0); x < std::min(view.width_px, x0 + dot_px); ++x)
        if (d.depth_mm < depth(x, y) - same_surface_mm) {
          depth(x, y) = d.depth_mm;
          picture.value(x, y) = d.value;
        }
  }
  return picture;
}

std::string scale_bar_html(double mm_per_px, int width_px) {
  if (!(mm_per_px > 0.0) || width_px <= 0) return "";
  const double most = 0.25 * mm_per_px * width_px;
  const double decade = std::pow(10.0, std::floor(std::log10(most)));
  const double length = (most >= 5.0 * decade ? 5.0 : most >= 2.0 * decade ? 2.0 : 1.0) * decade;
  return fmt::format("<div class=\"scale\"><span style=\"width:{:.2f}%\"></span>{:g} mm</div>",
                     100.0 * length / (mm_per_px * width_px), length);
}

}  // namespace fringetwin::report
