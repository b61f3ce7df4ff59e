// SPDX-License-Identifier: Apache-2.0
// Takes a run whose two sides are measured, and adds to the warnings of the real one what its images say
// against the description of the fringes.
#pragma once
#include "cosim/run.hpp"

namespace fringetwin::cosim {

/// Does nothing without real images.
void doubt_description(Run& run);

}  // namespace fringetwin::cosim
