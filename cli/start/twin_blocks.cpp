// SPDX-License-Identifier: Apache-2.0
#include "cli/start/twin_blocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fringetwin::cli {
namespace {

constexpr double kDiffuse = 0.8, kWhite = 0.8;  // paper; share of full scale that it has in white

/// Returns the smallest pitch p, 13 px or more, of which p, p + 1 and p + 2 are unambiguous over the width:
/// their beats repeat after p (p + 1) (p + 2)/2.
int first_pitch(int width) {
  int p = 13;
  while (static_cast<long long>(p) * (p + 1) * (p + 2) / 2 < width) ++p;
  return p;
}

/// Returns a length to a hundredth of a millimetre, as short as that can be written.
std::string length_text(double mm) { return fmt::format("{}", std::round(mm * 100.0) / 100.0 + 0.0); }

}  // namespace

std::string sensor_block(bool with_comment) {
  return fmt::format("[camera.sensor]\nbit_depth = 8\nread_noise_dn = 1.0\nelectrons_per_dn = 40.0{}\n\n",
                     with_comment ? "   # shot noise" : "");
}

std::string intensity_lines() {
  return fmt::format(
      "# White on paper (diffuse {}) is about 80 % of full scale: docs/HOW_BRIGHT.md\nintensity = {}\n\n",
      kDiffuse, std::round(kWhite * 255.0 * std::numbers::pi / kDiffuse));
}

std::string fringes_block(int projector_width_px) {
  const int pitch = first_pitch(projector_width_px);
  return fmt::format(
      "[fringes]\ndirections = [\"x\"]\npitches_px = [{}, {}, {}]   # unambiguous over the projector\nsteps "
      "= 4\nunwrap = \"heterodyne\"\n\n",
      pitch, pitch + 1, pitch + 2);
}

std::string ball_block(const Eigen::Vector3d& stand_mm, const Eigen::Vector3d& axis, double distance_mm,
                       double field_mm, double field_height_mm, std::optional<double> ball_mm) {
  const double radius =
      ball_mm ? 0.5 * *ball_mm : std::round(std::min(field_mm, field_height_mm) / 4.0 * 10.0) / 10.0;
  const Eigen::Vector3d center = stand_mm + (distance_mm + radius) * axis;
  return fmt::format(
      "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter_mm = [{}, {}, {}]   # its front is "
      "at the distance, its middle a radius behind\nradius_mm = {}\n"
      "[object.material]\ndiffuse = {}\n\n[[measure.fit]]\nobject = \"ball\"\n",
      length_text(center.x()), length_text(center.y()), length_text(center.z()), radius, kDiffuse);
}

}  // namespace fringetwin::cli
