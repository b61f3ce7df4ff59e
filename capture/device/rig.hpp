// SPDX-License-Identifier: Apache-2.0
// The cameras of a rig as devices, each under the name that the twin gives it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

/// A device and the camera of the twin it stands for.
struct RigCamera {
  std::string name;
  int stored_bits = 8;  ///< bit_depth of the twin's sensor
  std::unique_ptr<CameraDevice> device;
};
using Rig = std::vector<RigCamera>;

}  // namespace fringetwin::capture
