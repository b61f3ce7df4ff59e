// SPDX-License-Identifier: Apache-2.0
#include "study/plan/study_tables.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "study/plan/study_point.hpp"

namespace fringetwin::study {
namespace {

Range read_range(const TomlTable& table, bool sampled) {
  const Eigen::VectorXd ends = *table.vector("range", 2, NumberRange::any_size());
  Range range{ends[0], ends[1], table.integer("count", 2, kMostPoints),
              table.choice("scale", {"linear", "log"}) == "log"};
  if (!(range.first < range.last)) table.fail("range", "must rise");
  if (range.log && range.first <= 0.0) table.fail("range", "must be > 0 with scale = \"log\"");
  if (sampled && range.count)
    table.fail("count", "has no effect with this design", "points says how many there are");
  if (!sampled && !range.count) table.fail("count", "is missing", "the number of values along the range");
  return range;
}

}  // namespace

std::vector<std::string> read_study_keys(const TomlTable& table, std::set<std::string>* taken) {
  if (table.has("key") == table.has("keys")) table.fail("", "needs either key or keys");
  std::vector<std::string> keys;
  if (table.has("key"))
    keys = {table.required_string("key")};
  else
    keys = *table.strings("keys");
  const char* name = table.has("key") ? "key" : "keys";
  if (keys.empty()) table.fail(name, "must name one key or more");
  for (const std::string& key : keys)
    if (!taken->insert(key).second) table.fail(name, fmt::format("names \"{}\" a second time", key));
  constexpr std::string_view kExposure = ".exposure_ms";
  for (const std::string& key : keys) {
    if (!key.ends_with(kExposure)) continue;
    const std::string gain = key.substr(0, key.size() - kExposure.size()) + ".gain_dn";
    if (std::find(keys.begin(), keys.end(), gain) == keys.end())
      table.fail(name, fmt::format("\"{}\" alone changes no gray value", key),
                 fmt::format("give the gain that goes with it: keys = [\"{}\", \"{}\"] and rows", key, gain));
  }
  return keys;
}

Variation read_variation(const TomlTable& table, bool sampled, std::set<std::string>* taken) {
  table.allow({"key", "keys", "values", "rows", "range", "count", "scale"});
  Variation variation{read_study_keys(table, taken), {}, {}, std::nullopt};
  if (table.has("values") + table.has("rows") + table.has("range") != 1)
    table.fail("", "needs either values, rows or range");
  if (table.has("range")) {
    variation.range = read_range(table, sampled);
    return variation;
  }
  for (const char* key : {"count", "scale"})
    if (table.has(key)) table.fail(key, "has no effect without range");
  if (table.has("rows")) {
    variation.rows = *table.toml_rows("rows", variation.keys.size());
    for (const std::vector<std::string>& row : variation.rows) variation.values.push_back(row.front());
  } else {
    variation.values = *table.toml_texts("values");
  }
  if (variation.values.empty())
    table.fail(table.has("rows") ? "rows" : "values", "is empty, so the design is", "give one value or more");
  return variation;
}

std::vector<Record> read_records(const TomlTable& root) {
  std::vector<Record> records;
  std::set<std::string> names;
  for (const TomlTable& table : root.tables("record")) {
    table.allow({"result", "name", "expected_mean", "expected_sigma"});
    Record record{table.required_string("result"), ""};
    record.name = table.has("name") ? table.required_string("name") : record.result;
    if (!names.insert(record.name).second)
      table.fail(table.has("name") ? "name" : "result",
                 fmt::format("\"{}\" is the name of another record, too", record.name));
    records.push_back(record);
    for (const char* key : {"expected_mean", "expected_sigma"})
      if (table.has(key)) records.push_back({table.required_string(key), record.name + '.' + key});
  }
  return records;
}

}  // namespace fringetwin::study
