// SPDX-License-Identifier: Apache-2.0
// Takes what a twin leaves of the sampled gray values where the search for causes has named none, and says
// what it follows.
#pragma once
#include "compare/causes/sensitivity.hpp"
#include "compare/pattern/pattern.hpp"

namespace fringetwin::compare {

/// Returns what a predicted irradiance (laid out as the samples) leaves of a camera's values, with gain and
/// black level as they are set. What is beyond `scale`, in standard deviations, counts as Huber's weights
/// have it; `own`: what numbers of each pixel take is no rest.
LeftOver what_is_left(const GridSamples& samples, const std::vector<float>& irradiance, const Twin& twin,
                      double scale, FreePerPixel own);

/// Returns the pattern of what the twin as given leaves, with the gain and black level that fit best and the
/// weights and the scale that find_causes() left.
std::vector<PatternRow> pattern_of_rest(const Sensitivity& sensitivity, const Twin& twin);

}  // namespace fringetwin::compare
