// SPDX-License-Identifier: Apache-2.0
#include "tests/support/measure/measure_rig.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing {
namespace {

Lens scaled_lens(const Lens& lens, double scale) {
  std::vector<double> intrinsics = lens.intrinsics();
  for (int k = 0; k < 2; ++k) intrinsics[k] *= scale;
  for (int k = 2; k < 4; ++k) intrinsics[k] = (intrinsics[k] + 0.5) * scale - 0.5;
  const Eigen::Vector2i size(static_cast<int>(std::lround(lens.width() * scale)),
                             static_cast<int>(std::lround(lens.height() * scale)));
  return Lens("LENSMODEL_OPENCV4", intrinsics, size, "paper rig");
}

}  // namespace

Twin scaled_paper_rig(double scale) {
  Twin twin = paper_rig();
  for (Camera& camera : twin.cameras) {
    camera.lens = scaled_lens(camera.lens, scale);
    camera.sensor = {};
  }
  twin.projector->intensity = 1.0;
  return twin;
}

RaySurface sphere_surface(const Eigen::Vector3d& center_mm, double radius_mm) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
    const Eigen::Vector3d v = center_mm - o;
    const double middle = v.dot(d);
    const double miss_sq = (v - middle * d).squaredNorm();  // stable: no difference of squares of distances
    if (miss_sq > radius_mm * radius_mm) return std::nullopt;
    const double s = middle - std::sqrt(radius_mm * radius_mm - miss_sq);
    return s > 0.0 ? std::optional(s) : std::nullopt;
  };
}

RaySurface plane_surface(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& normal) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
    const double s = normal.dot(point_mm - o) / normal.dot(d);
    return s > 0.0 && std::isfinite(s) ? std::optional(s) : std::nullopt;
  };
}

RaySurface cylinder_surface(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& axis, double radius_mm) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
    const Eigen::Vector3d v = point_mm - o;
    const Eigen::Vector3d vp = v - v.dot(axis) * axis, dp = d - d.dot(axis) * axis;
    const double length = dp.norm();
    const Eigen::Vector3d e = dp / length;
    const double middle = vp.dot(e), miss_sq = (vp - middle * e).squaredNorm();
    if (miss_sq > radius_mm * radius_mm) return std::nullopt;
    const double s = (middle - std::sqrt(radius_mm * radius_mm - miss_sq)) / length;
    return s > 0.0 ? std::optional(s) : std::nullopt;
  };
}

RaySurface nearest(std::vector<RaySurface> scenes) {
  return [scenes = std::move(scenes)](const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
    std::optional<double> best;
    for (const RaySurface& scene : scenes)
      if (const auto s = scene(o, d); s && (!best || *s < *best)) best = s;
    return best;
  };
}

std::optional<Eigen::Vector3d> true_point(const Twin& twin, std::size_t camera, const Eigen::Vector2d& q_px,
                                          const RaySurface& scene) {
  const Camera& cam = twin.cameras[camera];
  const Pose T_world_cam = cam.T_cam_world.inverse();
  const auto ray = cam.lens.unproject(q_px);
  if (!ray) return std::nullopt;
  const Eigen::Vector3d d = T_world_cam.rotation * *ray;
  const auto s = scene(T_world_cam.translation_mm, d);
  if (!s) return std::nullopt;
  return T_world_cam.translation_mm + *s * d;
}

measure::CameraDecode ideal_decode(const Twin& twin, std::size_t camera, const RaySurface& scene,
                                   const MapOptions& options) {
  const Camera& cam = twin.cameras[camera];
  const Projector& projector = *twin.projector;
  const int width = cam.lens.width(), height = cam.lens.height();
  measure::CameraDecode decode;
  decode.camera = cam.name;
  decode.flags = ImageU8(width, height, measure::kOrderInvalid);
  for (const Axis axis : options.axes) {
    measure::DirectionDecode direction;
    direction.axis = axis;
    direction.pitches_px = {13, 14, 15};
    direction.coordinate_px = ImageD(width, height, std::numeric_limits<double>::quiet_NaN());
    direction.coordinate_sigma_px = ImageF(width, height, static_cast<float>(options.noise_px));
    decode.directions.push_back(direction);
  }
  const Eigen::Vector3d light = projector.center_world_mm();
#pragma omp parallel for schedule(dynamic, 8)
  for (int y = 0; y < height; ++y) {
    std::mt19937_64 random(options.seed * 100003u + static_cast<unsigned>(y));
    std::normal_distribution<double> noise(0.0, 1.0);
    for (int x = 0; x < width; ++x) {
      const auto p = true_point(twin, camera, {static_cast<double>(x), static_cast<double>(y)}, scene);
      if (!p) continue;
      const auto q = projector.lens.project(projector.T_proj_world * *p);
      if (!q || q->x() < -0.5 || q->y() < -0.5 || q->x() >= projector.lens.width() - 0.5 ||
          q->y() >= projector.lens.height() - 0.5)
        continue;
      if (options.shadows) {
        const Eigen::Vector3d d = *p - light;
        const auto s = scene(light, d.normalized());
        if (!s || *s < d.norm() - 1e-6) continue;
      }
      decode.flags(x, y) = measure::kValid;
      for (measure::DirectionDecode& direction : decode.directions)
        direction.coordinate_px(x, y) = (*q)[direction.axis == Axis::x ? 0 : 1] +
                                        (options.noise_px > 0.0 ? options.noise_px * noise(random) : 0.0);
    }
  }
  return decode;
}

}  // namespace fringetwin::testing
