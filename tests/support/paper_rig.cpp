// SPDX-License-Identifier: Apache-2.0
#include "tests/support/paper_rig.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::testing {
namespace {

Pose pose(std::array<double, 6> rt) { return pose_from_rt(Eigen::Map<const RotTrans>(rt.data())); }

Lens table_3(std::vector<double> intrinsics, int width, int height) {
  return Lens("LENSMODEL_OPENCV4", intrinsics, {width, height}, "Table 3 of the paper");
}

}  // namespace

Twin paper_rig() {
  Twin twin;
  twin.name = "paper rig";
  Sensor sensor;
  sensor.exposure_ms = 30.0;
  sensor.gain_dn = 20.0;
  twin.cameras.push_back(
      {.name = "left",
       .lens = table_3({2359.53, 2359.09, 734.47, 578.34, -0.1251, 0.1620, 0.0003, -0.0004}, 1440, 1080),
       .T_cam_world = {},
       .sensor = sensor,
       .optics = {}});
  twin.cameras.push_back(
      {.name = "right",
       .lens = table_3({2360.53, 2359.81, 736.99, 580.87, -0.1170, 0.1249, 0.0, -0.0002}, 1440, 1080),
       .T_cam_world = pose({-0.0086, 0.7078, 0.0058, -189.5009, -1.1664, 66.0589}),
       .sensor = sensor,
       .optics = {}});
  twin.projector.emplace(
      Projector{table_3({1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001}, 1280, 720),
                pose({-0.0099, 0.3754, 0.0276, -94.5914, -0.1889, 12.4706}),
                40.0,
                false,
                0.0,
                0.0,
                {},
                0.0});
  DirectionFringes d;
  d.axis = Axis::x;
  d.pitches_px = {13.0, 14.0, 15.0};
  d.phase_origin_px = {0.0, 0.0, 0.0};
  twin.fringes.directions = {d};
  return twin;
}

Twin with_object(Twin twin, const std::string& name, Shape shape, Material material) {
  twin.objects.push_back({name, std::move(shape), material});
  return twin;
}

SphereShape ideal_sphere() { return {.center_mm = {0.0, 0.0, 250.0}, .radius_mm = 5.0}; }
SphereShape physical_sphere() { return {.center_mm = {6.567, -5.497, 270.634}, .radius_mm = 19.065}; }
PlaneShape frontal_plane(double z_mm) {
  return {.point_mm = {0.0, 0.0, z_mm}, .normal = {0.0, 0.0, -1.0}, .size_mm = {}, .u_axis = {1.0, 0.0, 0.0}};
}
PlaneShape tilted_plane() {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.35, -0.2, -1.0).normalized();
  const Eigen::Vector3d u = (Eigen::Vector3d::UnitX() - normal.x() * normal).normalized();
  return {.point_mm = {5.0, -3.0, 280.0}, .normal = normal, .size_mm = {}, .u_axis = u};
}
CylinderShape upright_cylinder() {
  return {.point_mm = {4.0, 2.0, 275.0},
          .axis = Eigen::Vector3d(0.1, 1.0, 0.15).normalized(),
          .radius_mm = 12.0,
          .length_mm = {}};
}

Camera crop(const Camera& camera, int x0, int y0, int width, int height) {
  FT_CHECK(camera.lens.is_perspective(), "only perspective lenses have a principal point to shift");
  std::vector<double> intrinsics = camera.lens.intrinsics();
  intrinsics[2] -= x0;
  intrinsics[3] -= y0;
  Camera out = camera;
  out.lens = Lens(camera.lens.model(), intrinsics, {width, height}, camera.name + " cropped");
  return out;
}

Twin crop_around(Twin twin, const Eigen::Vector3d& point_world_mm, int width, int height) {
  for (Camera& camera : twin.cameras) {
    const auto q = camera.lens.project(camera.T_cam_world * point_world_mm);
    FT_CHECK(q.has_value(), "the point to crop around lies outside the camera's view");
    camera = crop(camera, static_cast<int>(std::lround(q->x())) - width / 2,
                  static_cast<int>(std::lround(q->y())) - height / 2, width, height);
  }
  return twin;
}

Twin only_camera(Twin twin, std::size_t index) {
  twin.cameras = {twin.cameras.at(index)};
  return twin;
}

Twin window_on_a_corner(double diffuse, int width, int height) {
  using Eigen::Vector3d;
  Twin twin = left_window({0, 0, 300}, width, height);
  for (const double side : {-1.0, 1.0})
    twin = with_object(twin, side < 0 ? "left_wall" : "right_wall",
                       PlaneShape{.point_mm = {10.0 * side, 0, 300},
                                  .normal = Vector3d(-side, 0, -1).normalized(),
                                  .size_mm = Eigen::Vector2d(60.0, 28.0),
                                  .u_axis = {0, 1, 0}},
                       {.diffuse = diffuse});
  return twin;
}

}  // namespace fringetwin::testing
