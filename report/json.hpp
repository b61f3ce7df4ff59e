// SPDX-License-Identifier: Apache-2.0
// Makes JSON values as every file of ours has them: keys in the order they were put, null for what is no
// number.
#pragma once
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace fringetwin::report {

using Json = nlohmann::ordered_json;

/// Null unless finite: JSON has neither NaN nor infinity.
inline Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// On one line; bytes that are no UTF-8 are replaced.
inline std::string json_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// An array of numbers.
template <class Numbers>
Json json_numbers(const Numbers& values) {
  Json out = Json::array();
  for (const double v : values) out.push_back(json_number(v));
  return out;
}

}  // namespace fringetwin::report
