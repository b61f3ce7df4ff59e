// SPDX-License-Identifier: Apache-2.0
// What exposures that do not fall wholly into one pattern see, once more and by another formula.
#pragma once
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the light of a pixel in row y of a camera in each image of the sequence, given what each pattern
/// alone would give: the mean over the exposure of what is shown meanwhile, the first and the last pattern
/// standing before and after the sequence.
std::vector<double> reference_exposed(const Camera& camera, int y, const std::vector<double>& of_patterns);

}  // namespace fringetwin::render
