// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/coverage_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace fringetwin::compare {
namespace {

constexpr int kEvery = 4;              ///< px: of the pixels measured on both sides every fourth is looked at
constexpr double kUsualGate_mm = 2.0;  ///< of a twin without a fit: what a fit would have

double gate_of(const Twin& twin, const std::string& object) {
  double widest = 0.0;
  for (const FitRequest& fit : twin.measure.fits) {
    if (fit.object == object) return fit.gate_mm;
    widest = std::max(widest, fit.gate_mm);
  }
  return widest > 0.0 ? widest : kUsualGate_mm;
}

/// Returns the label of a pixel by its own point; kUnknownObject where it has none, or none is asked for.
int own_label(const NearestObject& nearest, const PixelPoints& real, const PixelPoints& simulated, int x,
              int y) {
  const bool on_real = real.measured(x, y) != 0, on_simulated = simulated.measured(x, y) != 0;
  if (on_real && on_simulated && (x % kEvery != 0 || y % kEvery != 0)) return kUnknownObject;
  const PixelPoints& side = on_simulated ? simulated : real;
  if ((!on_real && !on_simulated) || side.index(x, y) < 0) return kUnknownObject;
  const int label = nearest(side.cloud.p_world_mm[side.index(x, y)]);
  // the simulated side has nothing but the twin's objects: a point off them is a poor one
  return label == kNoObject && on_simulated ? kUnknownObject : label;
}

/// Gives the pixels of the area without a label that of the nearest one, along ways within the area.
void grow(const ImageU8& area, Image<int>& labels) {
  std::vector<std::size_t> queue;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels.data[i] != kUnknownObject) queue.push_back(i);
  const auto width = static_cast<std::size_t>(area.width);
  for (std::size_t next = 0; next < queue.size(); ++next) {
    const int x = static_cast<int>(queue[next] % width), y = static_cast<int>(queue[next] / width);
    constexpr std::array<std::array<int, 2>, 4> kWays{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    for (const auto& [dx, dy] : kWays) {
      const int i = x + dx, j = y + dy;
      if (i < 0 || j < 0 || i >= area.width || j >= area.height) continue;
      if (area(i, j) == 0 || labels(i, j) != kUnknownObject) continue;
      labels(i, j) = labels(x, y);
      queue.push_back(area.index(i, j));
    }
  }
}

}  // namespace

NearestObject::NearestObject(const Twin& twin)
    : is_known_(std::ranges::all_of(twin.objects, measure::has_nominal_surface)) {
  if (!is_known_) return;
  for (const Object& object : twin.objects) {
    const double gate = gate_of(twin, object.name);
    surfaces_.emplace_back(object, gate);
    least_gate_mm_ = std::min(least_gate_mm_, gate);
  }
}

int NearestObject::operator()(const Eigen::Vector3d& p_world_mm) const {
  int nearest = kNoObject;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    if (const double d = surfaces_[i].distance_mm(p_world_mm); d < least)
      least = d, nearest = static_cast<int>(i);
  return nearest;
}

Image<int> points_of_pixels(const Twin& twin, std::size_t camera, const measure::PointCloud& cloud) {
  const Camera& seen_by = twin.cameras[camera];
  const int width = seen_by.lens.width(), height = seen_by.lens.height();
  if (camera == 0) return measure::point_grid(cloud, width, height);
  const auto n = static_cast<std::ptrdiff_t>(cloud.size());
  std::vector<Eigen::Vector3d> places(cloud.size());  ///< pixel and depth
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Eigen::Vector3d p_mm = seen_by.T_cam_world * cloud.p_world_mm[i];
    const auto q_px = seen_by.lens.project(p_mm);
    places[i] = q_px ? Eigen::Vector3d(q_px->x(), q_px->y(), p_mm.norm()) : Eigen::Vector3d::Constant(-1.0);
  }
  Image<int> index(width, height, -1);
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& at = places[i];
    if (!(at.x() > -0.5 && at.y() > -0.5 && at.x() < width - 0.5 && at.y() < height - 0.5)) continue;
    int& point = index(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
    if (point < 0 || at.z() < places[point].z()) point = static_cast<int>(i);
  }
  return index;
}

Image<int> object_labels(const Twin& twin, const PixelPoints& real, const PixelPoints& simulated,
                         const ImageU8& area) {
  Image<int> labels(area.width, area.height, kUnknownObject);
  const NearestObject nearest(twin);
  if (!nearest.is_known() || simulated.cloud.size() + real.cloud.size() == 0) return labels;
#pragma omp parallel for schedule(dynamic, 16)
  for (int y = 0; y < area.height; ++y)
    for (int x = 0; x < area.width; ++x)
      if (area(x, y) != 0) labels(x, y) = own_label(nearest, real, simulated, x, y);
  grow(area, labels);
  return labels;
}

}  // namespace fringetwin::compare
