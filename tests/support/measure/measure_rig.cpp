// SPDX-License-Identifier: Apache-2.0
#include "tests/support/measure/measure_rig.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

namespace fringetwin::measure::test_tools {
namespace {

Lens scaled_lens(std::vector<double> intrinsics, int width, int height, double scale) {
  for (int k = 0; k < 2; ++k) intrinsics[k] *= scale;
  for (int k = 2; k < 4; ++k) intrinsics[k] = (intrinsics[k] + 0.5) * scale - 0.5;
  const Eigen::Vector2i size(static_cast<int>(std::lround(width * scale)),
                             static_cast<int>(std::lround(height * scale)));
  return Lens("LENSMODEL_OPENCV4", intrinsics, size, "paper rig");
}

Pose pose(double r0, double r1, double r2, double t0, double t1, double t2) {
  RotTrans rt;
  rt << r0, r1, r2, t0, t1, t2;
  return pose_from_rt(rt);
}

}  // namespace

Twin paper_rig(double scale) {
  Twin twin;
  twin.name = "paper rig";
  twin.cameras.push_back(
      {"left",
       scaled_lens({2359.53, 2359.09, 734.47, 578.34, -0.1251, 0.1620, 0.0003, -0.0004}, 1440, 1080, scale),
       Pose{},
       Sensor{},
       {}});
  twin.cameras.push_back(
      {"right",
       scaled_lens({2360.53, 2359.81, 736.99, 580.87, -0.1170, 0.1249, 0, -0.0002}, 1440, 1080, scale),
       pose(-0.0086, 0.7078, 0.0058, -189.5009, -1.1664, 66.0589),
       Sensor{},
       {}});
  twin.projector = Projector{
      scaled_lens({1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001}, 1280, 720, 1.0),
      pose(-0.0099, 0.3754, 0.0276, -94.5914, -0.1889, 12.4706),
      1.0,
      false,
      0.0,
      0.0,
      {},
      0.0};
  DirectionFringes x;
  x.axis = Axis::x;
  x.pitches_px = {13, 14, 15};
  x.phase_origin_px = {0, 0, 0};
  twin.fringes.directions = {x};
  return twin;
}

Scene sphere_scene(const Eigen::Vector3d& center_mm, double radius_mm) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
    const Eigen::Vector3d v = center_mm - o;
    const double middle = v.dot(d);
    const double miss_sq = (v - middle * d).squaredNorm();  // stable: no difference of squares of distances
    if (miss_sq > radius_mm * radius_mm) return std::nullopt;
    const double s = middle - std::sqrt(radius_mm * radius_mm - miss_sq);
    return s > 0.0 ? std::optional(s) : std::nullopt;
  };
}

Scene plane_scene(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& normal) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
    const double s = normal.dot(point_mm - o) / normal.dot(d);
    return s > 0.0 && std::isfinite(s) ? std::optional(s) : std::nullopt;
  };
}

Scene cylinder_scene(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& axis, double radius_mm) {
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

Scene nearest(std::vector<Scene> scenes) {
  return [scenes = std::move(scenes)](const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
    std::optional<double> best;
    for (const Scene& scene : scenes)
      if (const auto s = scene(o, d); s && (!best || *s < *best)) best = s;
    return best;
  };
}

std::optional<Eigen::Vector3d> true_point(const Twin& twin, std::size_t camera, const Eigen::Vector2d& q_px,
                                          const Scene& scene) {
  const Camera& cam = twin.cameras[camera];
  const Pose T_world_cam = cam.T_cam_world.inverse();
  const auto ray = cam.lens.unproject(q_px);
  if (!ray) return std::nullopt;
  const Eigen::Vector3d d = T_world_cam.rotation * *ray;
  const auto s = scene(T_world_cam.translation_mm, d);
  if (!s) return std::nullopt;
  return T_world_cam.translation_mm + *s * d;
}

CameraDecode ideal_decode(const Twin& twin, std::size_t camera, const Scene& scene,
                          const MapOptions& options) {
  const Camera& cam = twin.cameras[camera];
  const Projector& projector = *twin.projector;
  const int width = cam.lens.width(), height = cam.lens.height();
  CameraDecode decode;
  decode.camera = cam.name;
  decode.flags = ImageU8(width, height, kOrderInvalid);
  for (const Axis axis : options.axes) {
    DirectionDecode direction;
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
      decode.flags(x, y) = kValid;
      for (DirectionDecode& direction : decode.directions)
        direction.coordinate_px(x, y) = (*q)[direction.axis == Axis::x ? 0 : 1] +
                                        (options.noise_px > 0.0 ? options.noise_px * noise(random) : 0.0);
    }
  }
  return decode;
}

}  // namespace fringetwin::measure::test_tools
