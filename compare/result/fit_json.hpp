// SPDX-License-Identifier: Apache-2.0
// Writes the fits of result.json, whose numbers stand in maps: one fit, and the row of one object with both
// sides.
#pragma once
#include <optional>

#include "compare/result/rows.hpp"
#include "report/json.hpp"

namespace fringetwin::compare {

/// Writes what the method itself adds to a fit; null where that is unknown.
report::Json bias_json(const std::optional<measure::ObjectFit>& fit);

/// Writes the numbers of one fit by their keys, null where the fit is not usable; null without a fit.
report::Json fit_json(const std::optional<measure::ObjectFit>& fit);

/// Writes both sides of one object, their difference and its z.
report::Json fit_row_json(const FitRow& row);

}  // namespace fringetwin::compare
