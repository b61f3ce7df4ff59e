// SPDX-License-Identifier: Apache-2.0
// Takes the devices of a calibration, and writes a commented twin.toml of them with a part to try it on.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/import/imported_rig.hpp"

namespace fringetwin::cli {

/// One device, and the file of its model as twin.toml names it.
struct CalibratedDevice {
  calib::ImportedDevice device;
  std::string model;
};

struct CalibratedRig {
  std::vector<CalibratedDevice> cameras;  ///< one or two
  std::optional<CalibratedDevice> projector;
  std::optional<double> ball_mm;      ///< diameter; else half of the smaller side of the field
  std::optional<double> distance_mm;  ///< of the part from the first camera; else where the axes come nearest
};

/// Returns the text. The ball stands on the axis of the first camera's image, where the axis of the other
/// device passes nearest: of the projector, else of the second camera.
std::string calibrated_twin_toml(const CalibratedRig& rig);

}  // namespace fringetwin::cli
