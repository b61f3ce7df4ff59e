// SPDX-License-Identifier: Apache-2.0
// Takes the numbers that a study records out of the result of one measurement.
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

}  // namespace fringetwin::study
