// SPDX-License-Identifier: Apache-2.0
#include "cli/start/new_twin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/start/twin_blocks.hpp"

namespace fringetwin::cli {
namespace {

/// Returns the keys of a lens without distortion, its principal point in the middle.
std::string pinhole(const std::string& device, const std::array<int, 2>& size, double focal_px) {
  const double f = std::round(focal_px * 10.0) / 10.0;
  return fmt::format(
      "lensmodel = \"LENSMODEL_PINHOLE\"   # or model = \"{}.cameramodel\", once it is calibrated\n"
      "imagersize = [{}, {}]\nintrinsics = [{}, {}, {}, {}]   # fx fy cx cy, px\n",
      device, size[0], size[1], f, f, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1));
}

std::string place(double x_mm, double distance_mm) {
  return fmt::format("position_mm = [{}, 0, 0]\nlook_at_mm = [0, 0, {}]\n", x_mm, distance_mm);
}

}  // namespace

std::string new_twin_toml(const NewRig& rig) {
  const double focal = rig.camera_px[0] * rig.distance_mm / rig.field_mm,
               height_mm = rig.field_mm * rig.camera_px[1] / rig.camera_px[0],
               // a tenth more than the camera's field in both directions
      throw_px = rig.distance_mm / 1.1 *
                 std::min(rig.projector_px[0] / rig.field_mm, rig.projector_px[1] / height_mm);
  const bool two = rig.cameras == 2;
  std::string text = fmt::format(
      "# A rig that is still to be built: change what you like, then render and measure it.\n"
      "# All keys: docs/formats/twin.md. World frame: the first camera, mm, x right, y down, z forward.\n"
      "schema = \"fringetwin-twin/1\"\nname = \"{}\"\n\n[[camera]]\nname = \"{}\"\n{}{}",
      rig.name, two ? "left" : "camera", pinhole(two ? "left" : "camera", rig.camera_px, focal),
      sensor_block(true));
  if (two)
    text += fmt::format("[[camera]]\nname = \"right\"\n{}{}{}", pinhole("right", rig.camera_px, focal),
                        place(rig.baseline_mm, rig.distance_mm), sensor_block(false));
  text +=
      fmt::format("[projector]\n{}{}{}", pinhole("projector", rig.projector_px, throw_px),
                  place(two ? 0.5 * rig.baseline_mm : rig.baseline_mm, rig.distance_mm), intensity_lines());
  return text + fringes_block(rig.projector_px[0]) +
         ball_block(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), rig.distance_mm, rig.field_mm,
                    height_mm, rig.ball_mm);
}

}  // namespace fringetwin::cli
