// SPDX-License-Identifier: Apache-2.0
#include "cli/start/new_twin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fringetwin::cli {
namespace {

constexpr double kDiffuse = 0.8, kWhite = 0.8;  // paper; share of full scale that it has in white

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

/// Returns the smallest pitch p, 13 px or more, of which p, p + 1 and p + 2 are unambiguous over the width:
/// their beats repeat after p (p + 1) (p + 2)/2.
int first_pitch(int width) {
  int p = 13;
  while (p * (p + 1) * (p + 2) / 2 < width) ++p;
  return p;
}

}  // namespace

std::string new_twin_toml(const NewRig& rig) {
  const double focal = rig.camera_px[0] * rig.distance_mm / rig.field_mm,
               height_mm = rig.field_mm * rig.camera_px[1] / rig.camera_px[0],
               // a tenth more than the camera's field in both directions
      throw_px = rig.distance_mm / 1.1 *
                 std::min(rig.projector_px[0] / rig.field_mm, rig.projector_px[1] / height_mm);
  const double intensity = std::round(kWhite * 255.0 * std::numbers::pi / kDiffuse);
  const int pitch = first_pitch(rig.projector_px[0]);
  const bool two = rig.cameras == 2;
  std::string text = fmt::format(
      "# A rig that is still to be built: change what you like, then render and measure it.\n"
      "# All keys: docs/formats/twin.md. World frame: the first camera, mm, x right, y down, z forward.\n"
      "schema = \"fringetwin-twin/1\"\nname = \"{}\"\n\n[[camera]]\nname = \"{}\"\n{}"
      "[camera.sensor]\nbit_depth = 8\nread_noise_dn = 1.0\nelectrons_per_dn = 40.0   # shot noise\n\n",
      rig.name, two ? "left" : "camera", pinhole(two ? "left" : "camera", rig.camera_px, focal));
  if (two)
    text += fmt::format(
        "[[camera]]\nname = \"right\"\n{}{}[camera.sensor]\nbit_depth = 8\nread_noise_dn = 1.0\n"
        "electrons_per_dn = 40.0\n\n",
        pinhole("right", rig.camera_px, focal), place(rig.baseline_mm, rig.distance_mm));
  text += fmt::format(
      "[projector]\n{}{}# White on paper (diffuse {}) is about 80 % of full scale: docs/HOW_BRIGHT.md\n"
      "intensity = {}\n\n",
      pinhole("projector", rig.projector_px, throw_px),
      place(two ? 0.5 * rig.baseline_mm : rig.baseline_mm, rig.distance_mm), kDiffuse, intensity);
  text += fmt::format(
      "[fringes]\ndirections = [\"x\"]\npitches_px = [{}, {}, {}]   # unambiguous over the projector\nsteps "
      "= 4\n"
      "unwrap = \"heterodyne\"\n\n",
      pitch, pitch + 1, pitch + 2);
  const double radius = std::round(std::min(rig.field_mm, height_mm) / 4.0 * 10.0) / 10.0;
  return text +
         fmt::format(
             "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter_mm = [0, 0, {}]\nradius_mm = {}\n"
             "[object.material]\ndiffuse = {}\n\n[[measure.fit]]\nobject = \"ball\"\n",
             rig.distance_mm + radius, radius, kDiffuse);
}

}  // namespace fringetwin::cli
