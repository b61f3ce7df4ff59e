// SPDX-License-Identifier: Apache-2.0
// Says what the gray values that a twin does not explain follow: gray level, phase of the fringes, image
// number, radius, place, or phase from place to place or from image to image (docs/metrics/causes.md,
// "Causes").
#pragma once
#include <string>
#include <vector>

#include "compare/pattern/left_values.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Returns a row for each coordinate. `excess`: of chi2 beyond noise, what the shares are of.
std::vector<PatternRow> find_pattern(const std::vector<LeftOver>& cameras, double excess);

/// Says in one sentence what is left follows, or that no pattern was found; empty without rows.
std::string pattern_sentence(const std::vector<PatternRow>& rows);

}  // namespace fringetwin::compare
