// SPDX-License-Identifier: Apache-2.0
// Lists the knee of a camera's response, its place and the slope beyond, as parameters of the group
// camera_knee (docs/metrics/causes.md, "Causes").
#pragma once
#include "compare/causes/parameter.hpp"

namespace fringetwin::compare {

/// Returns the slope beyond the knee and, after it, the knee's place, in this order: the place's effect is
/// that of the fitted slope. Empty where the camera's response is a table of more than one corner. Of a
/// camera whose response is straight the place begins at 40 % of its range; it changes nothing until the
/// slope has left 1.
std::vector<Parameter> knee_parameters(const Twin& twin, std::size_t camera);

}  // namespace fringetwin::compare
