// SPDX-License-Identifier: Apache-2.0
// Tells from the spelling of a fit's keys which is a standard error and which is a count, which keys a kind
// of fit has, and how its two sides were aligned.
#pragma once
#include <map>
#include <string>
#include <type_traits>
#include <vector>

namespace fringetwin::compare {

/// Returns the number or vector of a key; null where there is none.
template <class Value>
const Value* find_value(const std::map<std::string, Value>& values, const std::string& key) {
  const auto at = values.find(key);
  return at == values.end() ? nullptr : &at->second;
}
/// Returns the number or vector of a key, or `unknown`.
template <class Value>
Value value_or(const std::map<std::string, Value>& values, const std::string& key,
               const std::type_identity_t<Value>& unknown) {
  const Value* value = find_value(values, key);
  return value ? *value : unknown;
}

/// Returns the key of a number's standard error: "radius_mm" -> "radius_sigma_mm", "normal" ->
/// "normal_sigma".
std::string sigma_key(const std::string& key);
/// Returns true for keys that are standard errors themselves.
bool is_sigma_key(const std::string& key);

/// Returns true for the directions that tilts are about: a choice, nothing to subtract.
bool is_direction_key(const std::string& key);

/// Returns true for keys that count things ("n_gated"): neither lengths nor angles, nothing to subtract.
bool is_count_key(const std::string& key);

/// Returns the keys that every fit of this kind has besides its residual and its count; none for a mesh.
std::vector<std::string> keys_of_fit(const std::string& kind);

/// Says what moves the two sides before their fits of this kind are compared.
std::string alignment_of(const std::string& kind);

}  // namespace fringetwin::compare
