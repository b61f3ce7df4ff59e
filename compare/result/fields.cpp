// SPDX-License-Identifier: Apache-2.0
#include "compare/result/fields.hpp"

#include <algorithm>

namespace fringetwin::compare {

std::string unit_of_key(const std::string& key) {
  for (const auto& [end, unit] :
       {std::pair{"_mm", "mm"}, std::pair{"_px", "px"}, std::pair{"_rad", "rad"}, std::pair{"_rad2", "rad²"},
        std::pair{"_dn", "DN"}, std::pair{"_dn2", "DN²"}})
    if (key.ends_with(end)) return unit;
  return "";
}

const Field* find_field(const std::vector<Field>& all, const std::string& key) {
  const auto at = std::ranges::find_if(all, [&](const Field& f) { return f.key == key; });
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
