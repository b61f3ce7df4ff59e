// SPDX-License-Identifier: Apache-2.0
// Rows of result.json (docs/result.schema.json).
#pragma once
#include "compare/result/indicator_row.hpp"
#include "compare/result/noise_row.hpp"
#include "compare/result/shift_row.hpp"
#include "report/json.hpp"

namespace fringetwin::compare {

report::Json noise_json(const NoiseRow& row);
report::Json shift_json(const ShiftRow& row);
report::Json indicator_json(const Indicator& row);

/// What moves the two sides before their fits of this kind are compared.
std::string alignment_of(const std::string& kind);

}  // namespace fringetwin::compare
