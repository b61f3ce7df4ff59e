// SPDX-License-Identifier: Apache-2.0
// Takes the numbers that a study records out of the result of one measurement, and says how their paths and
// the settings they belong to are shown to a reader: short name, unit, value.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "study/plan/study_tables.hpp"

namespace fringetwin::study {

/// Returns the recorded numbers of a result by the records' names (the path where there is none); NaN where
/// it has null. A path finds entries of lists by their "object", "camera" or "name", or by index:
/// "fits.sphere.measured.radius_mm", "fits[0].measured.center_mm[2]". No records: all numbers of `fits`.
/// Throws UnknownKey for a path that leads nowhere, UserError(usage) for one that leads to no number.
std::map<std::string, double> pick_numbers(const nlohmann::ordered_json& result,
                                           const std::vector<Record>& records);

/// Returns the text of a TOML string without its quotes, any other value as it is.
std::string plain_value(const std::string& toml);
/// Returns "ball radius_mm" for "fits.ball.measured.radius_mm", any other name as it is.
std::string display_name(const std::string& path);
/// Returns "mm" for "fits.ball.measured.center_mm[2]"; an empty string when the name does not say the unit.
std::string unit_of(const std::string& path);

}  // namespace fringetwin::study
