// SPDX-License-Identifier: Apache-2.0
// Lists the Vulkan devices of this machine, with the facts about each that the program shows.
#pragma once
#include <string>
#include <vector>

namespace fringetwin::render {

struct DeviceInfo {
  std::string name;         ///< e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string driver;       ///< e.g. "llvmpipe Mesa 22.3.6"
  std::string api_version;  ///< e.g. "1.3.230"
  bool is_cpu = false;
  bool has_double = false;  ///< traces in double precision (shaderFloat64)
};

/// Returns the devices that can render (Vulkan 1.2 and a compute queue), in the loader's order; an empty list
/// when there is no Vulkan loader, driver or device. Implemented in vulkan/vulkan_device.cpp.
std::vector<DeviceInfo> list_devices();

}  // namespace fringetwin::render
