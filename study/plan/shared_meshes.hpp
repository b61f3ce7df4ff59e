// SPDX-License-Identifier: Apache-2.0
// Loads the meshes of a twin and takes over those that another twin has read already: a file is read once.
#pragma once
#include "twin/twin.hpp"

namespace fringetwin::study {

/// Does what fringetwin::load_meshes() does, but takes from `known` (may be null) what that has read.
void load_meshes(Twin* twin, const Twin* known);

}  // namespace fringetwin::study
