// SPDX-License-Identifier: Apache-2.0
// Rows of result.json (docs/result.schema.json).
#pragma once
#include "compare/noise_row.hpp"
#include "report/json.hpp"

namespace fringetwin::compare {

report::Json noise_json(const NoiseRow& row);

}  // namespace fringetwin::compare
