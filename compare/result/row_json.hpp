// SPDX-License-Identifier: Apache-2.0
// Rows of result.json (docs/result.schema.json).
#pragma once
#include "compare/result/rows.hpp"
#include "report/json.hpp"

namespace fringetwin::compare {

report::Json noise_json(const NoiseRow& row);
report::Json shift_json(const ShiftRow& row);
report::Json indicator_json(const Indicator& row);

}  // namespace fringetwin::compare
