// SPDX-License-Identifier: Apache-2.0
#include "study/design/design_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "measure/fit/object_fits.hpp"
#include "study/plan/recorded_numbers.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

/// The place or size of an object, stated by the twin, that a record measures.
struct Truth {
  std::string object, key;
  int index = -1;
};
std::optional<Truth> truth_of(const std::string& result) {
  const std::string start = "fits.", middle = ".measured.";
  const std::size_t at = result.find(middle);
  if (!result.starts_with(start) || at == std::string::npos) return std::nullopt;
  Truth out{result.substr(start.size(), at - start.size()), result.substr(at + middle.size()), -1};
  if (out.key == "radius_mm") return out;
  for (int i = 0; i < 3; ++i)
    if (out.key == fmt::format("center_mm[{}]", i)) return Truth{out.object, "center_mm", i};
  return std::nullopt;
}

double put_in(const Twin& twin, const Truth& truth) {
  const Object* object = twin.find_object(truth.object);
  const auto nominal = object ? measure::nominal_fit(*object) : std::nullopt;
  if (!nominal) return kNan;
  if (truth.index >= 0) {
    const auto vector = nominal->vectors.find(truth.key);
    return vector == nominal->vectors.end() ? kNan : vector->second[truth.index];
  }
  const auto number = nominal->numbers.find(truth.key);
  return number == nominal->numbers.end() ? kNan : number->second;
}

/// Returns the settings that a nominal centre or radius depends on.
Settings of_objects(const Settings& settings) {
  Settings out;
  for (const auto& [key, value] : settings)
    if (key.starts_with("object")) out.emplace(key, value);
  return out;
}

/// Returns the truths, [setting][number]; NaN where there is none.
std::vector<std::vector<double>> truths(const StudyHead& head, const std::vector<const Settings*>& settings,
                                        const std::vector<std::string>& results) {
  std::vector<std::optional<Truth>> wanted;
  for (const std::string& result : results) wanted.push_back(truth_of(result));
  std::vector<std::vector<double>> out(settings.size(), std::vector<double>(results.size(), kNan));
  if (std::ranges::none_of(wanted, [](const auto& t) { return t.has_value(); })) return out;
  std::map<Settings, std::size_t> known;  // objects -> a setting that has them
  for (std::size_t s = 0; s < settings.size(); ++s) {
    const Settings objects = of_objects(*settings[s]);
    if (const auto like = known.find(objects); like != known.end()) {
      out[s] = out[like->second];
      continue;
    }
    try {
      const Twin twin = load_twin(head.twin, *settings[s]);
      for (std::size_t k = 0; k < wanted.size(); ++k)
        if (wanted[k]) out[s][k] = put_in(twin, *wanted[k]);
      known.emplace(objects, s);
    } catch (const UserError&) {
      continue;  // a setting that is no twin has no runs either
    }
  }
  return out;
}

std::vector<std::string> names_of(const StudyHead& head, const std::vector<StoredPoint>& rows) {
  std::vector<std::string> names;
  for (const Record& r : head.records) names.push_back(r.name.empty() ? r.result : r.name);
  if (!names.empty()) return names;
  std::set<std::string> all;
  for (const StoredPoint& row : rows)
    for (const auto& [name, value] : row.outcome.numbers) all.insert(name);
  return {all.begin(), all.end()};
}

/// Returns the name of the number that a record of what is expected belongs to: its own without the ending.
std::string expected_of(const std::string& name, const std::string& ending) {
  return name.ends_with(ending) ? name.substr(0, name.size() - ending.size()) : "";
}

/// Moves the records of what is expected to their numbers.
void attach_expected(std::vector<TableNumber>* numbers) {
  const auto find = [&](const std::string& name) {
    return std::ranges::find(*numbers, name, &TableNumber::name);
  };
  std::set<std::string> moved;
  for (const TableNumber& expected : *numbers)
    for (const char* ending : {".expected_mean", ".expected_sigma"}) {
      const std::string name = expected_of(expected.name, ending);
      const auto number = name.empty() ? numbers->end() : find(name);
      if (number == numbers->end()) continue;
      auto& values = std::string(ending) == ".expected_mean" ? number->expected_mean : number->expected_sigma;
      for (const SettingRuns& runs : expected.runs) values.push_back(group_statistics({&runs}, 0.95).mean);
      moved.insert(expected.name);
    }
  std::erase_if(*numbers, [&](const TableNumber& n) { return moved.contains(n.name); });
}

double change_of(const TableNumber& number) {
  const GroupStatistics& g = number.all;
  const double per_setting = static_cast<double>(g.runs) / static_cast<double>(g.settings);
  const double noise = g.sigma * g.sigma / per_setting;
  if (!std::isfinite(g.between) || !std::isfinite(g.sigma)) return kNan;
  return noise > 0.0 ? g.between * g.between / noise : g.between > 0.0 ? 1e300 : 0.0;
}

}  // namespace

DesignTable design_table(const StudyHead& head, const DesignPlan& plan, const std::vector<StoredPoint>& rows,
                         double coverage) {
  DesignTable out;
  out.scattered = plan.is_sampled();
  const auto seeds = static_cast<std::size_t>(plan.noise_seeds);
  out.seeds = seeds;
  std::vector<const Settings*> settings;
  for (std::size_t i = 0; i < rows.size(); i += seeds) settings.push_back(&rows[i].point.settings);
  out.settings.resize(settings.size());
  if (plan.design == Design::list && plan.vary.size() > 1)
    add_joint_axis(plan.vary, settings, &out);
  else
    add_axes(plan.vary, settings, &out);

  const std::vector<std::string> names = names_of(head, rows);
  std::vector<std::string> results = names;
  for (std::size_t k = 0; k < head.records.size(); ++k) results[k] = head.records[k].result;
  const auto truth = truths(head, settings, results);
  for (std::size_t k = 0; k < names.size(); ++k) {
    TableNumber number;
    number.name = display_name(names[k]);
    number.unit = unit_of(results[k]);
    number.is_time = results[k] == "acquisition.time_s";
    number.is_measured = !results[k].starts_with("theory.") && !results[k].starts_with("acquisition.");
    number.is_error = truth_of(results[k]).has_value();
    number.runs.resize(settings.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto& numbers = rows[i].outcome.numbers;
      const auto value = numbers.find(names[k]);
      if (rows[i].status != PointStatus::done || value == numbers.end() || std::isnan(value->second))
        continue;
      const double known = truth[i / seeds][k];
      number.is_error = number.is_error && !std::isnan(known);
      number.runs[i / seeds].push_back({rows[i].point.seed, value->second});
    }
    if (number.is_error)
      for (std::size_t s = 0; s < settings.size(); ++s) {
        for (SeededValue& run : number.runs[s]) run.value -= truth[s][k];
        number.truth.push_back(truth[s][k]);
      }
    out.numbers.push_back(std::move(number));
  }
  attach_expected(&out.numbers);
  for (TableNumber& number : out.numbers) {
    std::vector<const SettingRuns*> all;
    for (const SettingRuns& runs : number.runs) all.push_back(&runs);
    number.all = group_statistics(all, coverage);
    number.change = change_of(number);
    if (number.is_error)
      for (std::size_t s = 0; s < number.expected_mean.size(); ++s)
        number.expected_mean[s] -= number.truth[s];
  }
  if (head.records.empty())
    std::ranges::stable_sort(out.numbers, [](const TableNumber& a, const TableNumber& b) {
      if (a.is_error != b.is_error) return a.is_error;
      return (std::isnan(a.change) ? -1.0 : a.change) > (std::isnan(b.change) ? -1.0 : b.change);
    });
  return out;
}

}  // namespace fringetwin::study
