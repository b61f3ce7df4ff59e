// SPDX-License-Identifier: Apache-2.0
// Holds a comparison against the acceptance limits of a twin. The names of the limits follow from the fields
// of the tables that carry one.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "compare/result/fields.hpp"
#include "compare/result/rows.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns every limit that a field of a table or of a fit carries, by the name that a twin gives it.
const std::map<std::string, Limit>& limits_by_name();

/// Refuses names in twin.limits that no table has, and limits that make no sense: throws UnknownKey or
/// UserError(usage) with file, line, key and the nearest known name. To be called before any work is done.
void check_limit_names(const Twin& twin);

/// Returns one row per limit, in alphabetical order. A quantity the comparison does not have counts as not
/// met (value NaN). Throws UserError(usage) for an unknown name.
std::vector<LimitRow> check_limits(const std::map<std::string, double>& limits, const Comparison& comparison,
                                   const std::string& where);

}  // namespace fringetwin::compare
