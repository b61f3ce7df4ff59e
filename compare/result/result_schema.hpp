// SPDX-License-Identifier: Apache-2.0
// Makes the JSON schema of result.json (docs/result.schema.json) from the fields of every table.
#pragma once
#include <string>

namespace fringetwin::compare {

/// Returns the JSON schema of result.json as the text of docs/result.schema.json.
std::string result_schema();

}  // namespace fringetwin::compare
