// SPDX-License-Identifier: Apache-2.0
// Checks a comparison against the acceptance limits in a twin's [limits]: the limits and the comparison's
// numbers go in, one row per limit with "met" or "not met" comes out. Which limits there are follows from the
// fields of result.json that carry one.
#pragma once
#include <filesystem>
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
/// UserError(usage) with file, line, key and the nearest known name; `settings`: those the twin was loaded
/// with.
void check_limit_names(const Twin& twin, const std::map<std::string, std::string>& settings = {});

/// Reads a twin as load_twin() does, and checks its limits: what every command starts with, before any work.
Twin load_checked_twin(const std::filesystem::path& file,
                       const std::map<std::string, std::string>& settings = {});

/// Returns one row per limit of a checked twin, in alphabetical order. A quantity the comparison does not
/// have counts as not met (value NaN).
std::vector<LimitRow> check_limits(const std::map<std::string, double>& limits, const Comparison& comparison);

}  // namespace fringetwin::compare
