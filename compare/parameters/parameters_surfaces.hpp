// SPDX-License-Identifier: Apache-2.0
// What a twin can be wrong about in how surfaces reflect, alone and to one another, as parameters.
#pragma once
#include <string>
#include <vector>

#include "compare/parameters/parameter.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns the parameters of a group of surfaces; none of other groups.
std::vector<Parameter> surface_parameters(const Twin& twin, const std::string& group);

}  // namespace fringetwin::compare
