// SPDX-License-Identifier: Apache-2.0
#include "tests/support/groove.hpp"

#include <Eigen/Geometry>
#include <complex>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing {

using Eigen::Vector2d;
using Eigen::Vector3d;

Twin rig_before(double distance_mm) {
  Twin twin = only_camera(paper_rig(), 0);
  twin.cameras[0].T_cam_world = Pose{};
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {640, 640, 79.5, 59.5}, {160, 120}, "small");
  const Vector3d at(60.0, 5.0, 0.0), to(0.0, 0.0, distance_mm);
  Pose& T = twin.projector->T_proj_world;
  T.rotation.row(2) = (to - at).normalized().transpose();
  T.rotation.row(0) = Vector3d(0, 1, 0).cross(to - at).normalized().transpose();
  T.rotation.row(1) = T.rotation.row(2).cross(T.rotation.row(0));
  T.translation_mm = -T.rotation * at;
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {900, 900, 320, 240}, {640, 480}, "small");
  twin.projector->inverse_square = false;
  twin.fringes.directions = {{Axis::x, {12.0, 60.0}, {0.0, 0.0}, {}}};
  twin.fringes.steps = 4;
  twin.objects.clear();
  return twin;
}

Twin groove(double diffuse, double length_mm) {
  Twin twin = rig_before(kApexMm - 15.0);
  for (const double side : {-1.0, 1.0}) {
    const Vector3d up = Vector3d(side, 0, -1).normalized();
    PlaneShape wall{.point_mm = Vector3d(0, 0, kApexMm) + 0.5 * kWallMm * up,
                    .normal = Vector3d(-side, 0, -1).normalized(),
                    .size_mm = Vector2d(length_mm, kWallMm),
                    .u_axis = {0, 1, 0}};
    twin = with_object(twin, side < 0 ? "left_wall" : "right_wall", wall, {diffuse, 0.0, 10.0});
  }
  return twin;
}

Differences differences(const Twin& twin, const render::Transport& found,
                        const std::vector<ReferenceBlockPixel>& truth) {
  const Sensor& sensor = twin.cameras[0].sensor;
  Differences out;
  for (const auto& p : truth) {
    if (!p.interior) continue;
    const std::complex<double> expected(p.pixel.cosine[0][0], p.pixel.sine[0][0]),
        light(static_cast<double>(found.cosine[0][0](p.x, p.y)),
              static_cast<double>(found.sine[0][0](p.x, p.y)));
    out.phase_rad.add(std::arg(light * std::conj(expected)));
    out.gray.add((static_cast<double>(found.mean(p.x, p.y)) - p.pixel.mean) * sensor.gain_dn /
                 sensor.max_dn());
  }
  return out;
}

}  // namespace fringetwin::testing
