// SPDX-License-Identifier: Apache-2.0
// Says which devices and objects a search for causes found elsewhere, so that a refinement can be of these
// alone: where all of them may move, so may everything together, and no image tells that.
#pragma once
#include <string>
#include <vector>

#include "compare/result/verdict_tables.hpp"

namespace fringetwin::compare {

/// Returns the places, as `--refine` takes them ("projector.turn_rad", "projector.shift_mm",
/// "ball.center_mm", "wall.tilt_rad"), of each device and object whose estimate is more than four standard
/// errors off the twin's in the groups "rig" and "pose". Empty where nothing is, or where either group has no
/// such place: then it is not both that moved.
std::vector<std::string> moved_parts(const Causes& causes);

}  // namespace fringetwin::compare
