// SPDX-License-Identifier: Apache-2.0
// Meshes of one twin for the next: a file is read once.
#pragma once
#include "twin/twin.hpp"

namespace fringetwin::study {

/// fringetwin::load_meshes(), but for what `known` (may be null) has read already.
void load_meshes(Twin* twin, const Twin* known);

}  // namespace fringetwin::study
