// SPDX-License-Identifier: Apache-2.0
#include "compare/result/fields.hpp"

#include <algorithm>

namespace fringetwin::compare {

const Field* find_field(const std::vector<Field>& all, const std::string& key) {
  const auto at = std::find_if(all.begin(), all.end(), [&](const Field& f) { return f.key == key; });
  return at == all.end() ? nullptr : &*at;
}

report::Json row_json(const std::vector<Field>& all, const void* row) {
  report::Json out = report::Json::object();
  for (const Field& field : all) {
    report::Json value = field.json(row);
    const bool empty = value.is_string() && value.get_ref<const std::string&>().empty();
    if (empty && field.omit_empty) continue;
    if (empty && field.empty_is_null) value = nullptr;
    out[field.key] = std::move(value);
  }
  return out;
}

}  // namespace fringetwin::compare
