// SPDX-License-Identifier: Apache-2.0
// Says in sentences, for the report, what a comparison of this twin can and cannot show.
#pragma once
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// Returns the sentence under a comparison of an object that was built from the capture itself, compared on
/// these steps (none: gray levels only); empty without such an object.
std::string measured_shape_note(const Twin& twin, const std::vector<int>& compared_steps);

/// Returns the sentences under a comparison with published numbers instead of images: what it shows when the
/// virtual object is the published result itself, and when it is not. Empty without published numbers.
std::string published_results_note(const Twin& twin);

}  // namespace fringetwin::cosim
