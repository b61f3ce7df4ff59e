// SPDX-License-Identifier: Apache-2.0
// Which numbers of a result a study keeps.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "study/plan/study_tables.hpp"

namespace fringetwin::study {

/// The recorded numbers of a result.json by the records' names (the path where there is none); NaN where it
/// has null. A path finds entries of lists by their "object", "camera" or "name", or by index:
/// "fits.sphere.measured.radius_mm", "fits[0].measured.center_mm[2]". No records: all numbers of `fits`.
/// `more_json`: further entries beside the result's (image_results).
/// Throws UnknownKey for a path that leads nowhere, UserError(usage) for one that leads to no number.
std::map<std::string, double> pick_numbers(const std::string& result_json, const std::vector<Record>& records,
                                           const std::string& more_json = "{}");

}  // namespace fringetwin::study
