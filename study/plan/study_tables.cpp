// SPDX-License-Identifier: Apache-2.0
#include "study/plan/study_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "study/plan/space_filling.hpp"
#include "study/plan/study_point.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::study {
namespace {

constexpr std::size_t kMostStudyKeys = 1000;  // twins have some 200; every point holds a value of each

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

/// Returns the value at the share i / n of the range: both ends exact, whole steps whole.
double along(const Range& range, double i, double n) {
  if (i == 0.0) return range.first;
  if (i == n) return range.last;
  const double value =
      range.log ? std::pow(10.0, (std::log10(range.first) * (n - i) + std::log10(range.last) * i) / n)
                : range.first + (range.last - range.first) * i / n;
  return std::clamp(value, range.first, range.last);
}

void assign(const Variation& variation, const std::string& value, Settings* settings) {
  for (const std::string& key : variation.keys) (*settings)[key] = value;
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
  if (keys.size() + taken->size() > kMostStudyKeys)
    table.fail(name, fmt::format("brings the study to {} keys, at most {} are possible",
                                 keys.size() + taken->size(), kMostStudyKeys));
  for (const std::string& key : keys)
    if (!taken->insert(key).second) table.fail(name, fmt::format("names \"{}\" a second time", key));
  constexpr std::string_view kExposure = ".exposure_ms";
  for (const std::string& key : keys) {
    if (!key.ends_with(kExposure)) continue;
    const std::string gain = key.substr(0, key.size() - kExposure.size()) + ".gain_dn";
    if (std::ranges::find(keys, gain) == keys.end())
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

std::vector<std::string> listed_values(const Variation& variation) {
  if (!variation.range) return variation.values;
  std::vector<std::string> values;
  const int count = variation.range->count.value_or(0);
  for (int i = 0; i < count; ++i) values.push_back(number_text(along(*variation.range, i, count - 1)));
  return values;
}

std::string value_at(const Variation& variation, double u) {
  if (variation.range) return number_text(along(*variation.range, u, 1.0));
  return variation.values[share_of(u, variation.values.size())];
}

void assign_listed(const Variation& variation, const std::vector<std::string>& values, std::size_t i,
                   Settings* settings) {
  if (variation.rows.empty()) return assign(variation, values[i], settings);
  for (std::size_t k = 0; k < variation.keys.size(); ++k)
    (*settings)[variation.keys[k]] = variation.rows[i][k];
}

void assign_at(const Variation& variation, double u, Settings* settings) {
  if (variation.range)
    assign(variation, value_at(variation, u), settings);
  else
    assign_listed(variation, variation.values, share_of(u, variation.values.size()), settings);
}

}  // namespace fringetwin::study
