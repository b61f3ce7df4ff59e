// SPDX-License-Identifier: Apache-2.0
// Reads JSON lines that someone else may have written: the library alone would take 1e99 for a whole number,
// and what becomes of that is undefined.
#pragma once
#include <concepts>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "twin/file/json_bounds.hpp"

namespace fringetwin {

/// Returns the value that a text is. Throws std::out_of_range where it asks for more than the library may be
/// given (docs/FORMATS.md, "Limits"), and the library's exceptions where it is no JSON.
template <class Json>
Json parse_json(std::string_view text) {
  if (const std::string excess = json_excess(text); !excess.empty()) throw std::out_of_range(excess);
  return Json::parse(text);
}

/// Returns a whole number. Throws std::out_of_range for one beyond its type and for one with a fraction or an
/// exponent, and the library's exceptions for what is no number.
template <std::integral Whole, class Json>
Whole whole_number(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.template get<typename Json::number_unsigned_t>();
    if (std::in_range<Whole>(number)) return static_cast<Whole>(number);
  } else if (value.is_number_integer()) {
    const auto number = value.template get<typename Json::number_integer_t>();
    if (std::in_range<Whole>(number)) return static_cast<Whole>(number);
  } else if (!value.is_number()) {
    value.template get_ref<const typename Json::number_integer_t&>();  // throws, and says what it is
  }
  throw std::out_of_range(value.dump() + " is no whole number of its range");
}

}  // namespace fringetwin
