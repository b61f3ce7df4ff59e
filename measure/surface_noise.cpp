// SPDX-License-Identifier: Apache-2.0
#include "measure/surface_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

/// A vertex that lies no further than this from a pixel's middle is that pixel's.
constexpr double kSamePixel_px = 0.01;

/// Returns the median over the pixels that have a value; 0 where none has.
double median_of(const ImageF& image) {
  std::vector<float> values = image.data;
  const double median = upper_median(values);  // of those that are numbers
  return std::isnan(median) ? 0.0 : median;
}

/// Returns a camera's optical axis in the world frame.
Eigen::Vector3d axis_of(const Camera& camera) {
  return camera.T_cam_world.rotation.transpose() * Eigen::Vector3d::UnitZ();
}

double larger(double a, double b) { return std::abs(a) > std::abs(b) ? a : b; }

void put_larger(const ImageF& from, ImageF& to) {
  for (std::size_t i = 0; i < from.size(); ++i)
    if (std::isnan(to.data[i]) || std::abs(from.data[i]) > std::abs(to.data[i])) to.data[i] = from.data[i];
}

}  // namespace

double lateral_step(const Lens& lens) {
  const double cx = 0.5 * (lens.width() - 1), cy = 0.5 * (lens.height() - 1);
  const auto a = lens.unproject({cx, cy}), b = lens.unproject({cx + 1.0, cy});
  return a && b ? (*a - *b).norm() : 1e-3;
}

NoiseInView::NoiseInView(const Twin& twin, std::size_t camera, std::size_t measured_by)
    : twin_(twin),
      camera_(camera),
      camera_mm_(twin.cameras[camera].center_world_mm()),
      axis_(axis_of(twin.cameras[camera])),
      measured_by_mm_(twin.cameras[measured_by].center_world_mm()),
      axis_measured_by_(axis_of(twin.cameras[measured_by])) {
  const Lens& lens = twin.cameras[camera].lens;
  seen_.shading = ImageF(lens.width(), lens.height(), std::numeric_limits<float>::quiet_NaN());
  seen_.radius_px = depth_mm_ = seen_.shading;
  px_ratio_ = lateral_step(twin.cameras[measured_by].lens) / lateral_step(lens);
  for (const DirectionFringes& d : twin.fringes.directions)
    if (twin.projector) seen_.moved_px[d.axis == Axis::x ? 0 : 1] = seen_.shading;
}

Eigen::Vector2d NoiseInView::moved_px(const VertexNoise& vertex) const {
  Eigen::Matrix<double, 2, 3> px_per_mm;
  const Pose& T_proj_world = twin_.projector->T_proj_world;
  if (!twin_.projector->lens.project(T_proj_world * vertex.p_mm, &px_per_mm)) return Eigen::Vector2d::Zero();
  // a surface that moves by as much along its normal is met further along this camera's ray
  const Eigen::Vector3d from_camera = vertex.p_mm - camera_mm_, from_measured = vertex.p_mm - measured_by_mm_;
  const Eigen::Vector3d ray = from_camera / from_camera.dot(axis_),
                        measured_ray = from_measured / from_measured.dot(axis_measured_by_);
  const double further_mm = vertex.depth_mm * vertex.normal.dot(measured_ray) / vertex.normal.dot(ray);
  return px_per_mm * (T_proj_world.rotation * ray) * further_mm;
}

void NoiseInView::add(const VertexNoise& vertex, std::optional<Eigen::Vector2d> q_px) {
  const Camera& camera = twin_.cameras[camera_];
  // a camera sees but the front
  if (!(vertex.normal.dot(vertex.p_mm - measured_by_mm_) * vertex.normal.dot(vertex.p_mm - camera_mm_) > 0.0))
    return;
  if (!q_px) q_px = camera.lens.project(camera.T_cam_world * vertex.p_mm);
  if (!q_px) return;
  const double depth_mm = (vertex.p_mm - camera_mm_).dot(axis_),
               measured_depth_mm = (vertex.p_mm - measured_by_mm_).dot(axis_measured_by_);
  const auto radius_px = static_cast<float>(vertex.radius_px * px_ratio_ * measured_depth_mm / depth_mm);
  const Eigen::Vector2d moved = twin_.projector ? moved_px(vertex) : Eigen::Vector2d::Zero();
  const auto first = [](double q) { return static_cast<int>(std::ceil(q - 1.0 + kSamePixel_px)); };
  const auto last = [](double q) { return static_cast<int>(std::floor(q + 1.0 - kSamePixel_px)); };
  ImageF& shading = seen_.shading;
  for (int y = std::max(0, first(q_px->y())); y <= std::min(shading.height - 1, last(q_px->y())); ++y)
    for (int x = std::max(0, first(q_px->x())); x <= std::min(shading.width - 1, last(q_px->x())); ++x) {
      if (depth_mm_(x, y) < depth_mm) continue;  // NaN: nothing is there yet
      depth_mm_(x, y) = static_cast<float>(depth_mm);
      shading(x, y) = static_cast<float>(vertex.shading);
      seen_.radius_px(x, y) = radius_px;
      for (const int axis : {0, 1})
        if (ImageF& moved_px = seen_.moved_px[axis]; !moved_px.empty())
          moved_px(x, y) = static_cast<float>(moved[axis]);
    }
}

SurfaceNoiseInView NoiseInView::finish() && {
  seen_.median_shading = median_of(seen_.shading);
  for (const int axis : {0, 1}) seen_.median_moved_px[axis] = median_of(seen_.moved_px[axis]);
  return std::move(seen_);
}

void put_larger(const SurfaceNoise& from, SurfaceNoise& to) {
  to.leverage = std::max(to.leverage, from.leverage);
  to.radius_px = std::max(to.radius_px, from.radius_px);
  for (std::size_t c = 0; c < from.of_camera.size(); ++c) {
    const SurfaceNoiseInView& other = from.of_camera[c];
    SurfaceNoiseInView& own = to.of_camera[c];
    put_larger(other.shading, own.shading);
    put_larger(other.radius_px, own.radius_px);
    own.median_shading = std::max(own.median_shading, other.median_shading);
    for (const int axis : {0, 1}) {
      put_larger(other.moved_px[axis], own.moved_px[axis]);
      own.median_moved_px[axis] = larger(own.median_moved_px[axis], other.median_moved_px[axis]);
    }
  }
}

}  // namespace fringetwin::measure
