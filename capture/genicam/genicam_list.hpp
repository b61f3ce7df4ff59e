// SPDX-License-Identifier: Apache-2.0
// Finds GenICam cameras by the names that users write, and lists those there are.
#pragma once
#include <map>

#include "capture/genicam/genicam_module.hpp"

namespace fringetwin::capture {

/// Returns the one that "genicam:SERIAL" means: by serial number, id or address. Throws UserError(device)
/// that lists what there is when none or several are meant.
const GenicamListed& find_genicam(const std::vector<GenicamListed>& all, const std::string& name);

/// Opens the camera that the name asks for, and waits for one whose last program was killed to be free again.
/// Throws UserError(device) that says which cameras there are.
std::unique_ptr<GenicamDevice> open_genicam(const std::string& name,
                                            std::map<std::string, std::string>* provenance,
                                            GenicamModule& module = genicam_module());

/// Some lines of text on one camera: formats, ranges, triggers.
std::string describe(GenicamModule& module, const GenicamListed& listed);

/// Some lines for each camera; without the module or Aravis one line that says what to install. Never throws.
std::vector<std::string> list_genicam_cameras();

}  // namespace fringetwin::capture
