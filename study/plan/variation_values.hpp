// SPDX-License-Identifier: Apache-2.0
// The values that the keys of a [[vary]] or [[choose]] take, as TOML text.
#pragma once
#include <string>
#include <vector>

#include "study/plan/study_point.hpp"
#include "study/plan/study_tables.hpp"

namespace fringetwin::study {

/// Returns all values in their order; of a range without `count` none.
std::vector<std::string> listed_values(const Variation& variation);
/// Returns the value at a place u in [0, 1]: along the range, or of the list the one in whose equal share u
/// lies.
std::string value_at(const Variation& variation, double u);

/// Gives all keys of the variation what they take with the i-th of its listed values.
void assign_listed(const Variation& variation, const std::vector<std::string>& values, std::size_t i,
                   Settings* settings);
/// Gives all keys of the variation what they take at the place u in [0, 1].
void assign_at(const Variation& variation, double u, Settings* settings);

}  // namespace fringetwin::study
