// SPDX-License-Identifier: Apache-2.0
// Takes the rough numbers of a rig that is still to be built, and writes a commented twin.toml of it.
#pragma once
#include <array>
#include <optional>
#include <string>

namespace fringetwin::cli {

struct NewRig {
  std::string name = "new rig";
  int cameras = 1;
  std::array<int, 2> camera_px{2448, 2048}, projector_px{1280, 720};
  double distance_mm = 250.0, baseline_mm = 100.0, field_mm = 125.0;
  std::optional<double> ball_mm = {};  ///< diameter; else half of the smaller side of the field
};

/// Returns the text: the first camera at the origin looks along +z at a ball in its middle, the projector
/// (between two cameras) and the second camera beside it look there, too; white is about 80 % of full scale.
std::string new_twin_toml(const NewRig& rig);

}  // namespace fringetwin::cli
