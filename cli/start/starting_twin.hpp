// SPDX-License-Identifier: Apache-2.0
// Writes the twin.toml that a calibration or an import leaves to go on from.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::cli {

/// Returns a twin.toml to go on from, of devices by their names, each with whether it is the projector; their
/// models are NAME.cameramodel beside it.
std::string starting_twin_toml(const std::string& name,
                               const std::vector<std::pair<std::string, bool>>& devices);

}  // namespace fringetwin::cli
