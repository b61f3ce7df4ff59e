// SPDX-License-Identifier: Apache-2.0
// Takes a run whose two sides are measured, and returns what its real images say against the description of
// the fringes, for the warnings of the real side.
#pragma once
#include <vector>

#include "cosim/run.hpp"
#include "measure/description/doubts.hpp"

namespace fringetwin::cosim {

/// Returns the doubts about the description of the real images; none without them. Adds the time to the run.
std::vector<measure::Doubt> doubts_about_real_side(Run& run);

/// Adds the doubts to the warnings of the real side, where there is one.
void add_to_warnings(Run& run, const std::vector<measure::Doubt>& doubts);

/// Puts another warning before those of the simulated side, where it was measured; an empty one not.
void add_first_warning(Run& run, const std::string& warning);

}  // namespace fringetwin::cosim
