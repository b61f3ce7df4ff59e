// SPDX-License-Identifier: Apache-2.0
#include "cli/start/calibrated_twin.hpp"

#include <fmt/format.h>

#include "cli/start/twin_blocks.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::cli {
namespace {

constexpr double kDistance_mm = 250.0;  ///< where axes that do not approach each other tell none

/// The ray through the middle of a device's image, in the reference's frame.
struct MiddleRay {
  Eigen::Vector3d stand_mm, direction;
};

MiddleRay axis_of(const calib::ImportedDevice& d) {
  const Lens lens(d.lensmodel, d.intrinsics, {d.imagersize_px[0], d.imagersize_px[1]}, d.where);
  const Eigen::Vector2d middle(0.5 * (lens.width() - 1), 0.5 * (lens.height() - 1));
  const Pose T_ref_device = d.T_device_ref.inverse();
  return {T_ref_device.translation_mm,
          T_ref_device.rotation * lens.unproject(middle).value_or(Eigen::Vector3d::UnitZ())};
}

/// Returns how far along `a` the other axis passes nearest.
double nearest_mm(const MiddleRay& a, const MiddleRay& b) {
  const double cosine = a.direction.dot(b.direction), sine_squared = 1.0 - cosine * cosine;
  const Eigen::Vector3d between = b.stand_mm - a.stand_mm;
  const double along = (a.direction - cosine * b.direction).dot(between) / sine_squared;
  return sine_squared > 1e-6 && along > 1.0 ? along : kDistance_mm;
}

double distance_of(const CalibratedRig& rig, const MiddleRay& first) {
  if (rig.distance_mm) return *rig.distance_mm;
  if (rig.projector) return nearest_mm(first, axis_of(rig.projector->device));
  return rig.cameras.size() > 1 ? nearest_mm(first, axis_of(rig.cameras[1].device)) : kDistance_mm;
}

}  // namespace

std::string calibrated_twin_toml(const CalibratedRig& rig) {
  std::string text =
      "# A calibrated rig, with a ball to try it on: describe your sensor, fringes and part.\n"
      "# All keys: docs/formats/twin.md. World frame: the reference of the models, mm, x right, y down, z "
      "forward.\n"
      "schema = \"fringetwin-twin/1\"\nname = \"calibrated rig\"\ncameramodel_unit = \"m\"   # mrcal's\n\n";
  for (const CalibratedDevice& camera : rig.cameras)
    text += fmt::format("[[camera]]\nname = {}\nmodel = {}\n{}", toml_string(camera.device.name),
                        toml_string(camera.model), sensor_block(&camera == &rig.cameras.front()));
  if (rig.projector)
    text += fmt::format("[projector]\nmodel = {}\n{}", toml_string(rig.projector->model), intensity_lines());
  text += fringes_block(rig.projector ? rig.projector->device.imagersize_px[0] : kUsualWidth_px);
  const calib::ImportedDevice& first = rig.cameras.front().device;
  const MiddleRay axis = axis_of(first);
  const double distance = distance_of(rig, axis);
  const auto seen = [&](int size_px, double focal_px) { return size_px * distance / focal_px; };
  return text + ball_block(axis.stand_mm, axis.direction, distance,
                           seen(first.imagersize_px[0], first.intrinsics.at(0)),
                           seen(first.imagersize_px[1], first.intrinsics.at(1)), rig.ball_mm);
}

}  // namespace fringetwin::cli
