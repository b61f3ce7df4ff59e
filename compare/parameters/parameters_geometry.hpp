// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of a twin that say where things are and how large, and how devices look: those that
// move the fringes over the camera's image.
#pragma once
#include "compare/parameters/parameter.hpp"

namespace fringetwin::compare {

/// Returns the parameters of the groups pose, size, rig, intrinsics and lens; none of others.
std::vector<Parameter> geometry_parameters(const Twin& twin, const std::string& group);

/// Returns those of the group motion, which a twin holds (Object::motion) and which are rendered: for every
/// parameter of the group pose, in its order, by how far it moves from the first image to the last.
std::vector<Parameter> motion_parameters(const Twin& twin);

/// Returns the keys of twin.toml that hold the size of a shape, and their numbers.
std::vector<PlaceKey> size_keys(const Shape& shape);

}  // namespace fringetwin::compare
