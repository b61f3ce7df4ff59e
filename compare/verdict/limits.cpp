// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/limits.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "compare/result/fit_keys.hpp"
#include "compare/result/tables.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/nearest_word.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::compare {
namespace {

/// Finds the worst of several values; it is NaN when there is none or one is unknown.
class Worst {
 public:
  explicit Worst(bool smallest_is_worst = false) : smallest_(smallest_is_worst) {}
  void add(double value) {
    if (!any_)
      value_ = value;
    else if (std::isnan(value) || std::isnan(value_))
      value_ = kNaN;
    else
      value_ = smallest_ ? std::min(value_, value) : std::max(value_, value);
    any_ = true;
  }
  double value() const { return value_; }

 private:
  bool smallest_ = false, any_ = false;
  double value_ = kNaN;
};

/// Returns the number that is compared with the limit: the value itself, or its distance from 1 for ratios
/// that should be 1.
double judged(const Limit& limit, double value) {
  return limit.worst == Limit::Worst::farthest_from_one ? std::abs(value - 1.0) : value;
}

/// Adds the values of the table's fields that carry this limit, from all rows of the comparison.
void add_rows(const Table& table, const std::string& name, const Comparison& c, Worst& worst) {
  for (const Field& field : table.fields()) {
    if (!field.limit || field.limit->name != name) continue;
    const report::Json rows = table.of_comparison(c);
    for (const report::Json& row : rows) {
      const report::Json& value = row.at(field.key);
      worst.add(value.is_number() ? judged(*field.limit, value.get<double>()) : kNaN);
    }
  }
}

/// Returns whether fits of this kind of object have a number with this key.
bool is_number_of(const std::string& kind, const std::string& key) {
  const std::vector<std::string> keys = keys_of_fit(kind);
  return std::ranges::find(keys, key) != keys.end();
}

/// Adds the amount of a fit's difference between the two sides; an unknown value when the kind of object has
/// that number but the fit lacks the difference.
void add_difference(const FitRow& row, const std::string& key, Worst& worst) {
  if (const auto at = row.difference_vectors.find(key); at != row.difference_vectors.end())
    worst.add(at->second.cwiseAbs().maxCoeff());
  else if (const auto number = row.difference.find(key); number != row.difference.end())
    worst.add(std::abs(number->second));
  else if (is_number_of(row.kind, key))
    worst.add(kNaN);
}

/// Adds a number of the simulated side's fit; an unknown value when that fit has none.
void add_simulated(const FitRow& row, const std::string& key, Worst& worst) {
  const bool known = row.simulated && row.simulated->usable && row.simulated->numbers.contains(key);
  worst.add(known ? row.simulated->numbers.at(key) : kNaN);
}

void add_fits(const std::string& name, const Comparison& c, Worst& worst) {
  for (const Field& field : fit_fields()) {
    if (!field.limit || field.limit->name != name) continue;
    const bool of_difference = field.limit->worst == Limit::Worst::largest_difference;
    for (const FitRow& row : c.fits) (of_difference ? add_difference : add_simulated)(row, field.key, worst);
  }
}

/// Returns the worst value, over fits and tables, of the quantity that this limit bounds.
double value_of(const Limit& limit, const Comparison& c) {
  Worst worst(limit.is_least());
  add_fits(limit.name, c, worst);
  for (const Table& table : tables())
    if (table.of_comparison) add_rows(table, limit.name, c, worst);
  return worst.value();
}

void collect(const std::vector<Field>& fields, std::map<std::string, Limit>& out) {
  for (const Field& field : fields)
    if (field.limit) out.emplace(field.limit->name, *field.limit);
}

/// Returns file and line of a limit, or the setting it was loaded with; the file alone where it was put into
/// the twin by other means.
std::string place_of(const Twin& twin, const std::map<std::string, std::string>& settings,
                     const std::string& name) {
  if (!std::filesystem::is_regular_file(twin.file)) return twin.file.string();
  const auto table = TomlTable::parse_file(twin.file, ExitCode::usage, settings).table("limits");
  return table ? table->where(name) : twin.file.string();
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& [name, limit] : limits_by_name()) all.push_back(name);
  return all;
}

}  // namespace

const std::map<std::string, Limit>& limits_by_name() {
  static const std::map<std::string, Limit> all = [] {
    std::map<std::string, Limit> out;
    collect(fit_fields(), out);
    for (const Table& table : tables()) collect(table.fields(), out);
    return out;
  }();
  return all;
}

void check_limit_names(const Twin& twin, const std::map<std::string, std::string>& settings) {
  for (const auto& [name, value] : twin.limits) {
    const auto limit = limits_by_name().find(name);
    if (limit == limits_by_name().end()) {
      const std::string hint = did_you_mean(name, names());
      throw UnknownKey(ExitCode::usage, place_of(twin, settings, name),
                       fmt::format("unknown key \"{}\" in [limits]", name),
                       hint.empty() ? fmt::format("known keys: {}", fmt::join(names(), ", ")) : hint);
    }
    if (value > limit->second.highest)
      throw UserError(
          ExitCode::usage, place_of(twin, settings, name),
          fmt::format("limits.{} must be >= 0 and <= {}, is {}", name, limit->second.highest, value));
  }
}

Twin load_checked_twin(const std::filesystem::path& file,
                       const std::map<std::string, std::string>& settings) {
  Twin twin = load_twin(file, settings);
  check_limit_names(twin, settings);
  return twin;
}

std::vector<LimitRow> check_limits(const std::map<std::string, double>& limits,
                                   const Comparison& comparison) {
  std::vector<LimitRow> rows;
  for (const auto& [name, limit] : limits) {
    const Limit& of = limits_by_name().at(name);
    LimitRow row{name, value_of(of, comparison), limit, false};
    row.pass = of.is_least() ? row.value >= limit : row.value <= limit;  // false for NaN
    rows.push_back(row);
  }
  return rows;
}

}  // namespace fringetwin::compare
