// SPDX-License-Identifier: Apache-2.0
// Acceptance limits of the twin against a comparison.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "compare/result/result.hpp"

namespace fringetwin::compare {

/// Names a twin may limit, with what they mean.
const std::map<std::string, std::string>& limit_names();

/// One row per limit, in alphabetical order. A quantity the comparison does not have counts as not
/// met (value NaN). Throws UserError(usage) for an unknown name.
std::vector<LimitRow> check_limits(const std::map<std::string, double>& limits, const Comparison& comparison,
                                   const std::string& where);

}  // namespace fringetwin::compare
