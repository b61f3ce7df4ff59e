// SPDX-License-Identifier: Apache-2.0
// Chooses the phase steps that `cosim --steps` compares.
#pragma once
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// Returns every second phase step, of those that may be compared (empty: all): "even" begins with the first
/// step, "odd" with the second. Throws UserError(usage) where fewer than three are left.
std::vector<int> compared_steps(const Twin& twin, const std::string& which, const std::vector<int>& allowed);

}  // namespace fringetwin::cosim
