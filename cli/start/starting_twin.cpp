// SPDX-License-Identifier: Apache-2.0
#include "cli/start/starting_twin.hpp"

#include <fmt/format.h>

#include "cli/start/twin_blocks.hpp"

namespace fringetwin::cli {
namespace {

// Paper (diffuse 0.8) that faces both devices has the irradiance 800 * 0.8 / pi = 204 in white, and as many
// gray values with the sensor's gain of 1 DN: 80 % of full scale (docs/HOW_BRIGHT.md).
constexpr const char* kBrightness =
    "# White on paper (diffuse 0.8) is 204 of 255 gray values: intensity * diffuse / pi * gain_dn, gain_dn = "
    "1.\n"
    "intensity = 800.0\n";

}  // namespace

std::string starting_twin_toml(const std::string& name, const std::vector<StartingDevice>& devices,
                               const KeptTables& kept) {
  int width_px = kUsualWidth_px;
  std::string toml =
      fmt::format("schema = \"fringetwin-twin/1\"\nname = \"{}\"\ncameramodel_unit = \"m\"\n", name);
  for (const StartingDevice& device : devices) {
    const auto of_camera = kept.of_camera.find(device.name);
    if (device.is_projector) width_px = device.width_px;
    if (device.is_projector)
      toml += fmt::format("\n[projector]\nmodel = \"{}.cameramodel\"\n{}", device.name,
                          kept.projector.empty() ? kBrightness : kept.projector);
    else
      toml += fmt::format("\n[[camera]]\nname = \"{0}\"\nmodel = \"{0}.cameramodel\"\n{1}", device.name,
                          of_camera == kept.of_camera.end() ? "" : of_camera->second);
  }
  if (!kept.fringes.empty())
    return toml + "\n# Describe the part and what to fit (docs/FORMATS.md).\n[fringes]\n" + kept.fringes;
  return toml + "\n# Describe the projected sequence (docs/FORMATS.md), then the part and what to fit.\n" +
         fringes_block(width_px);
}

}  // namespace fringetwin::cli
