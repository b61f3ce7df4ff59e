// SPDX-License-Identifier: Apache-2.0
#include "study/plan/recorded_numbers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <set>

#include "report/json.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::study {
namespace {

using report::Json;

const std::vector<std::string> kNameKeys{"object", "camera", "name"};

std::string name_of(const Json& entry) {
  for (const std::string& key : kNameKeys)
    if (entry.is_object() && entry.contains(key) && entry[key].is_string())
      return entry[key].get<std::string>();
  return "";
}

std::vector<std::string> choices(const Json& at) {
  std::vector<std::string> all;
  if (at.is_object())
    for (const auto& item : at.items()) all.push_back(item.key());
  if (at.is_array())
    for (const Json& entry : at) all.push_back(name_of(entry));
  std::erase(all, "");
  return all;
}

// "a.b[2]" -> a, b, [2]
std::vector<std::string> split_path(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.' || c == '[') parts.emplace_back();
    if (c != '.') parts.back() += c;
  }
  std::erase(parts, "");
  return parts;
}

const Json* step_into(const Json& at, const std::string& part) {
  if (at.is_object()) return at.contains(part) ? &at[part] : nullptr;
  if (!at.is_array()) return nullptr;
  if (part.starts_with('[')) {
    const std::optional<std::size_t> i = parse_number<std::size_t>(part.substr(1, part.size() - 2));
    return part.ends_with(']') && i && *i < at.size() ? &at[*i] : nullptr;
  }
  for (const Json& entry : at)
    if (name_of(entry) == part) return &entry;
  return nullptr;
}

/// What is not finite is unknown, as in a file: JSON has no infinity.
double number_or_nan(const Json& at) {
  const double value = at.is_null() ? kNaN : at.get<double>();
  return std::isfinite(value) ? value : kNaN;
}

double number_at(const Json& result, const std::string& path) {
  const Json* at = &result;
  for (const std::string& part : split_path(path)) {
    if (at->is_null()) break;  // what is unknown as a whole is unknown in its parts
    const Json* next = step_into(*at, part);
    if (!next) {
      const std::vector<std::string> there = choices(*at);
      throw UnknownKey(ExitCode::usage, fmt::format("result \"{}\"", path),
                       fmt::format("there is no \"{}\"", part),
                       there.empty() ? "" : fmt::format("there is: {}", fmt::join(there, ", ")));
    }
    at = next;
  }
  if (!at->is_null() && !at->is_number())
    throw UserError(ExitCode::usage, fmt::format("result \"{}\"", path), "is no number",
                    at->is_array() ? "add an index, e.g. [0]" : "");
  return number_or_nan(*at);
}

void flatten(const Json& at, const std::string& path, std::map<std::string, double>* out) {
  if (at.is_object()) {
    for (const auto& item : at.items()) flatten(item.value(), path + "." + item.key(), out);
  } else if (at.is_array()) {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const std::string name = name_of(at[i]);
      flatten(at[i], name.empty() ? fmt::format("{}[{}]", path, i) : path + "." + name, out);
    }
  } else if (at.is_null() || at.is_number()) {
    (*out)[path] = number_or_nan(at);
  }
}

}  // namespace

std::map<std::string, double> pick_numbers(const Json& result, const std::vector<Record>& records) {
  std::map<std::string, double> numbers;
  if (records.empty()) flatten(result.at("fits"), "fits", &numbers);
  for (const Record& r : records) numbers[r.name.empty() ? r.result : r.name] = number_at(result, r.result);
  return numbers;
}

std::string plain_value(const std::string& toml) {
  const bool simple = toml.size() >= 2 && toml.front() == '"' && toml.back() == '"' &&
                      toml.find_first_of("\"\\", 1) == toml.size() - 1;
  return simple ? toml.substr(1, toml.size() - 2) : toml;
}

std::string display_name(const std::string& path) {
  const std::string start = "fits.", middle = ".measured.";
  const std::size_t at = path.find(middle);
  if (!path.starts_with(start) || at == std::string::npos) return path;
  return path.substr(start.size(), at - start.size()) + " " + path.substr(at + middle.size());
}

std::string unit_of(const std::string& path) {
  std::string last = path.substr(path.rfind('.') + 1);  // without a '.' the whole path
  last = last.substr(0, last.find('['));
  const std::size_t at = last.rfind('_');
  const std::string end = at == std::string::npos ? "" : last.substr(at + 1);
  static const std::set<std::string> units = {"mm", "rad", "px", "s", "ms", "deg"};
  return units.contains(end) ? end : end == "dn" ? "DN" : "";
}

}  // namespace fringetwin::study
