// SPDX-License-Identifier: Apache-2.0
// Which numbers of a result a study keeps.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace fringetwin::study {

/// "fits.sphere.measured.radius_mm": a path into what `measure` writes as result.json; entries of a list by
/// their "object", "camera" or "name", or by index: "fits[0].measured.center_mm[2]".
struct Record {
  std::string result;
  std::string name;  ///< of the column; empty: the path
};

/// The recorded numbers of a result.json; NaN where it has null. No records: all numbers of `fits`.
/// Throws UnknownKey for a path that leads nowhere, UserError(usage) for one that leads to no number.
std::map<std::string, double> pick_numbers(const std::string& result_json,
                                           const std::vector<Record>& records);

}  // namespace fringetwin::study
