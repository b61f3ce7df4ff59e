// SPDX-License-Identifier: Apache-2.0
// calibrate --projector-from: a projector solved from the shape that two calibrated cameras measure.
#pragma once
#include <array>
#include <optional>
#include <string>

#include "cli/commands.hpp"

namespace fringetwin::cli {

struct ProjectorFromCommand {
  std::string twin, captures, out;
  std::optional<std::array<int, 2>> imagersize_px = {};  ///< of the projector; else that of the twin's
  bool solve_k1 = false, json = false;
};

/// Measures by stereo, solves, writes. Returns the exit code.
int run_projector_from(const ProjectorFromCommand& o, const Invocation& invocation);

}  // namespace fringetwin::cli
