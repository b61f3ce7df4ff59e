// SPDX-License-Identifier: Apache-2.0
// Takes a run whose two sides are measured, and returns what its real images say against the description of
// the fringes.
#pragma once
#include <string>
#include <vector>

#include "cosim/run.hpp"

namespace fringetwin::cosim {

/// Returns a sentence each, for the warnings of the real side; none without real images. Adds the time to the
/// run.
std::vector<std::string> description_doubts(Run& run);

}  // namespace fringetwin::cosim
