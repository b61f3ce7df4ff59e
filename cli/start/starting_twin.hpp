// SPDX-License-Identifier: Apache-2.0
// Writes the twin.toml that a calibration or an import leaves to go on from.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "twin/file/toml_kept.hpp"

namespace fringetwin::cli {

/// Returns a twin.toml to go on from, of devices by their names, each with whether it is the projector; their
/// models are NAME.cameramodel beside it. Fringes, sensors and light are those of `kept`; what it lacks is
/// made up.
std::string starting_twin_toml(const std::string& name,
                               const std::vector<std::pair<std::string, bool>>& devices,
                               const KeptTables& kept = {});

}  // namespace fringetwin::cli
