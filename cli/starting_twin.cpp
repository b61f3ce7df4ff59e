// SPDX-License-Identifier: Apache-2.0
#include "cli/starting_twin.hpp"

#include <fmt/format.h>

namespace fringetwin::cli {

std::string starting_twin_toml(const std::string& name,
                               const std::vector<std::pair<std::string, bool>>& devices) {
  std::string toml =
      fmt::format("schema = \"fringetwin-twin/1\"\nname = \"{}\"\ncameramodel_unit = \"m\"\n", name);
  for (const auto& [device, is_projector] : devices)
    toml += is_projector
                ? fmt::format("\n[projector]\nmodel = \"{}.cameramodel\"\nintensity = 40.0\n", device)
                : fmt::format("\n[[camera]]\nname = \"{0}\"\nmodel = \"{0}.cameramodel\"\n", device);
  return toml +
         "\n# Describe the projected sequence (docs/FORMATS.md), then the part and what to fit.\n"
         "[fringes]\ndirections = [\"x\"]\npitches_px = [13, 14, 15]\nsteps = 4\nunwrap = \"heterodyne\"\n";
}

}  // namespace fringetwin::cli
