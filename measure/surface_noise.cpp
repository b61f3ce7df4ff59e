// SPDX-License-Identifier: Apache-2.0
#include "measure/surface_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "measure/depth_fit.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

/// A vertex that lies no further than this from a pixel's middle is that pixel's.
constexpr double kSamePixel_px = 0.01;

/// A surface that another camera sees this much flatter says nothing there of what windows smooth away: its
/// rays are met too far off.
constexpr double kMostFurther = 5.0;

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

/// Takes each value with its noise.
void put_larger(const SmoothedInView& from, SmoothedInView& to) {
  for (std::size_t i = 0; i < from.value.size(); ++i)
    if (std::abs(from.value.data[i]) > std::abs(to.value.data[i]))
      to.value.data[i] = from.value.data[i], to.noise.data[i] = from.noise.data[i];
}

}  // namespace

void SmoothedInView::set_size(const Lens& lens) { value = noise = ImageF(lens.width(), lens.height(), 0.0F); }

void SmoothedInView::put(int x, int y, const Smoothed& smoothed) {
  value(x, y) = static_cast<float>(smoothed.value), noise(x, y) = static_cast<float>(smoothed.noise);
}

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
  seen_.radius_px = depth_mm_ = off_px_ = seen_.shading;
  same_surface_ = DepthMap::kSteepest * lateral_step(lens);
  seen_.smoothed_shading.set_size(lens);
  px_ratio_ = lateral_step(twin.cameras[measured_by].lens) / lateral_step(lens);
  for (const DirectionFringes& d : twin.fringes.directions)
    if (const int axis = d.axis == Axis::x ? 0 : 1; twin.projector)
      seen_.moved_px[axis] = seen_.shading, seen_.smoothed_px[axis].set_size(lens);
}

Eigen::Vector3d NoiseInView::further_mm_per_mm(const VertexNoise& vertex) const {
  // a surface that moves by as much along its normal is met further along this camera's ray
  const Eigen::Vector3d from_camera = vertex.p_mm - camera_mm_, from_measured = vertex.p_mm - measured_by_mm_;
  const Eigen::Vector3d ray = from_camera / from_camera.dot(axis_),
                        measured_ray = from_measured / from_measured.dot(axis_measured_by_);
  return vertex.normal.dot(measured_ray) / vertex.normal.dot(ray) * ray;
}

Eigen::Vector2d NoiseInView::moved_px_per_mm(const VertexNoise& vertex,
                                             const Eigen::Vector3d& further) const {
  Eigen::Matrix<double, 2, 3> px_per_mm;
  if (!twin_.projector) return Eigen::Vector2d::Zero();
  const Pose& T_proj_world = twin_.projector->T_proj_world;
  if (!twin_.projector->lens.project(T_proj_world * vertex.p_mm, &px_per_mm)) return Eigen::Vector2d::Zero();
  return px_per_mm * (T_proj_world.rotation * further);
}

bool NoiseInView::is_nearer(double depth_mm, double off_px, int x, int y) const {
  const double there_mm = static_cast<double>(depth_mm_(x, y));
  if (std::isnan(there_mm)) return true;  // nothing is there yet
  // the nearest of a surface's own vertices would be those whose noise lies towards the camera
  if (std::abs(depth_mm - there_mm) > same_surface_ * there_mm) return depth_mm < there_mm;
  return off_px < static_cast<double>(off_px_(x, y));
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
  const Eigen::Vector3d further = further_mm_per_mm(vertex);
  const Eigen::Vector2d moved_per_mm = moved_px_per_mm(vertex, further);
  const bool tells_depth = further.dot(axis_) < kMostFurther;
  const auto first = [](double q) { return static_cast<int>(std::ceil(q - 1.0 + kSamePixel_px)); };
  const auto last = [](double q) { return static_cast<int>(std::floor(q + 1.0 - kSamePixel_px)); };
  ImageF& shading = seen_.shading;
  for (int y = std::max(0, first(q_px->y())); y <= std::min(shading.height - 1, last(q_px->y())); ++y)
    for (int x = std::max(0, first(q_px->x())); x <= std::min(shading.width - 1, last(q_px->x())); ++x) {
      const double off_px = std::hypot(x - q_px->x(), y - q_px->y());
      if (!is_nearer(depth_mm, off_px, x, y)) continue;
      depth_mm_(x, y) = static_cast<float>(depth_mm);
      off_px_(x, y) = static_cast<float>(off_px);
      shading(x, y) = static_cast<float>(vertex.shading);
      seen_.smoothed_shading.put(x, y, vertex.smoothed_shading);
      seen_.radius_px(x, y) = radius_px;
      for (const int axis : {0, 1})
        if (ImageF& moved_px = seen_.moved_px[axis]; !moved_px.empty()) {
          moved_px(x, y) = static_cast<float>(moved_per_mm[axis] * vertex.depth_mm);
          seen_.smoothed_px[axis].put(
              x, y, tells_depth ? vertex.smoothed_depth_mm.times(moved_per_mm[axis]) : Smoothed{});
        }
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
    put_larger(other.smoothed_shading, own.smoothed_shading);
    put_larger(other.radius_px, own.radius_px);
    own.median_shading = std::max(own.median_shading, other.median_shading);
    for (const int axis : {0, 1}) {
      put_larger(other.moved_px[axis], own.moved_px[axis]);
      put_larger(other.smoothed_px[axis], own.smoothed_px[axis]);
      own.median_moved_px[axis] = larger(own.median_moved_px[axis], other.median_moved_px[axis]);
    }
  }
}

}  // namespace fringetwin::measure
