// SPDX-License-Identifier: Apache-2.0
// Writes the twin.toml that a calibration or an import leaves to go on from.
#pragma once
#include <string>
#include <vector>

#include "twin/file/toml_kept.hpp"

namespace fringetwin::cli {

/// A device of the rig, whose model is NAME.cameramodel beside the twin.toml.
struct StartingDevice {
  std::string name;
  int width_px = 0;  ///< of its image
  bool is_projector = false;
};

/// Returns a twin.toml to go on from. Fringes, sensors and light are those of `kept`; what it lacks is made
/// up: pitches that are unambiguous over the projector.
std::string starting_twin_toml(const std::string& name, const std::vector<StartingDevice>& devices,
                               const KeptTables& kept = {});

}  // namespace fringetwin::cli
