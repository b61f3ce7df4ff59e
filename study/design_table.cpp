// SPDX-License-Identifier: Apache-2.0
#include "study/design_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "study/chain.hpp"
#include "study/design.hpp"
#include "twin/errors.hpp"

namespace fringetwin::study {
namespace {

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path)
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// "camera.*.sensor.gain_dn" of the left's and the right's; keys that differ more side by side.
std::string label_of(const std::vector<std::string>& keys) {
  std::vector<std::string> common = split(keys[0]);
  for (const std::string& key : keys) {
    const std::vector<std::string> parts = split(key);
    if (parts.size() != common.size() || parts.back() != common.back())
      return fmt::format("{} and {} more", keys[0], keys.size() - 1);
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i] != common[i]) common[i] = "*";
  }
  std::string out;
  for (const std::string& part : common) out += (out.empty() ? "" : ".") + part;
  return out;
}

double number_of(const std::string& text) {
  double value = kNan;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : kNan;
}

/// With as few digits as tell the numbers apart, four at least.
std::vector<std::string> level_names(const std::vector<std::string>& texts) {
  std::vector<std::string> out;
  for (int digits = 4; digits <= 17; ++digits) {
    out.clear();
    for (const std::string& text : texts) {
      const double value = number_of(text);
      out.push_back(std::isnan(value) ? plain_value(text) : fmt::format("{:.{}g}", value, digits));
    }
    if (std::set<std::string>(out.begin(), out.end()).size() == texts.size()) break;
  }
  return out;
}

/// Of the values that occur: numbers in their order, else in the order of the design.
VariedAxis axis_of(const std::string& label, const std::string& brief, std::vector<std::string> texts,
                   bool log) {
  VariedAxis axis{label, brief, true, log, {}, {}};
  for (const std::string& text : texts) axis.numeric = axis.numeric && std::isfinite(number_of(text));
  std::vector<std::string> unique;
  std::set<std::string> seen;
  for (const std::string& text : texts)
    if (seen.insert(text).second) unique.push_back(text);
  if (axis.numeric)
    std::sort(unique.begin(), unique.end(),
              [](const std::string& a, const std::string& b) { return number_of(a) < number_of(b); });
  for (std::size_t i = 0; i < unique.size(); ++i) {
    axis.values.push_back(axis.numeric ? number_of(unique[i]) : static_cast<double>(i));
  }
  axis.names = level_names(unique);
  if (axis.numeric && axis.values.front() > 0.0 && axis.values.back() > 10.0 * axis.values.front())
    axis.log = true;
  axis.log = axis.log && axis.numeric && axis.values.front() > 0.0;
  return axis;
}

std::string brief_of(const Variation& v) { return split(v.keys[0]).back(); }

/// The first key's values stand for those of all keys, unless rows repeat them.
bool first_stands_for_all(const Variation& v) {
  return std::set<std::string>(v.values.begin(), v.values.end()).size() == v.values.size();
}

/// The keys whose value is shown: with rows those of the first key's kind.
std::string label_of(const Variation& v) {
  if (v.rows.empty()) return label_of(v.keys);
  std::vector<std::string> alike;
  for (const std::string& key : v.keys)
    if (split(key).back() == brief_of(v) && split(key).size() == split(v.keys[0]).size())
      alike.push_back(key);
  const std::size_t others = v.keys.size() - alike.size();
  return label_of(alike) + (others > 0 ? " and what goes with it" : "");
}

/// The text of one [[vary]] in each setting.
std::vector<std::string> texts_of(const Variation& v, const std::vector<const Settings*>& settings) {
  std::vector<std::string> out;
  for (const Settings* s : settings) {
    std::string text = s->at(v.keys[0]);
    if (!v.rows.empty() && !first_stands_for_all(v))
      for (std::size_t k = 1; k < v.keys.size(); ++k) text += ", " + plain_value(s->at(v.keys[k]));
    out.push_back(text);
  }
  return out;
}

void add_axis(const VariedAxis& axis, const std::vector<std::string>& texts, DesignTable* table) {
  if (axis.values.size() < 2) {
    table->fixed.push_back(axis);
    return;
  }
  std::map<std::string, std::size_t> level;
  for (const std::string& text : texts) level.emplace(text, level.size());
  for (std::size_t s = 0; s < texts.size(); ++s) {
    std::size_t at = 0;
    if (axis.numeric) {
      const double value = number_of(texts[s]);
      at = static_cast<std::size_t>(std::lower_bound(axis.values.begin(), axis.values.end(), value) -
                                    axis.values.begin());
    } else {
      at = level.at(texts[s]);
    }
    table->settings[s].level.push_back(at);
  }
  table->axes.push_back(axis);
}

/// The values of a list stand side by side: together they are one thing that varies.
void add_list_axis(const StudyFile& study, const std::vector<const Settings*>& settings, DesignTable* table) {
  std::vector<std::string> joined(settings.size());
  std::string label, brief;
  for (const Variation& v : study.vary) {
    const std::vector<std::string> texts = texts_of(v, settings);
    for (std::size_t s = 0; s < texts.size(); ++s)
      joined[s] += (joined[s].empty() ? "" : ", ") + plain_value(texts[s]);
    label += (label.empty() ? "" : ", ") + label_of(v);
    brief += (brief.empty() ? "" : ", ") + brief_of(v);
  }
  add_axis(axis_of(label, brief, joined, false), joined, table);
}

void add_axes(const StudyFile& study, const std::vector<const Settings*>& settings, DesignTable* table) {
  if (study.design == Design::list && study.vary.size() > 1) {
    add_list_axis(study, settings, table);
    return;
  }
  std::set<std::string> briefs;
  for (const Variation& v : study.vary) briefs.insert(brief_of(v));
  for (const Variation& v : study.vary) {
    const std::vector<std::string> texts = texts_of(v, settings);
    const std::string label = label_of(v);
    const bool distinct = briefs.size() == study.vary.size();
    add_axis(axis_of(label, distinct ? brief_of(v) : label, texts, v.range && v.range->log), texts, table);
  }
}

/// Where a record is a place or size that the twin states: its truth in each setting.
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
  const auto nominal = object ? nominal_fit(*object) : std::nullopt;
  if (!nominal) return kNan;
  if (truth.index >= 0) {
    const auto vector = nominal->vectors.find(truth.key);
    return vector == nominal->vectors.end() ? kNan : vector->second[truth.index];
  }
  const auto number = nominal->numbers.find(truth.key);
  return number == nominal->numbers.end() ? kNan : number->second;
}

/// [setting][number]; NaN where there is no truth.
std::vector<std::vector<double>> truths(const StudyFile& study, const std::vector<const Settings*>& settings,
                                        const std::vector<std::string>& results) {
  std::vector<std::optional<Truth>> wanted;
  for (const std::string& result : results) wanted.push_back(truth_of(result));
  std::vector<std::vector<double>> out(settings.size(), std::vector<double>(results.size(), kNan));
  if (std::none_of(wanted.begin(), wanted.end(), [](const auto& t) { return t.has_value(); })) return out;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    try {
      const Twin twin = load_twin(study.twin, *settings[s]);
      for (std::size_t k = 0; k < wanted.size(); ++k)
        if (wanted[k]) out[s][k] = put_in(twin, *wanted[k]);
    } catch (const UserError&) {
      continue;  // a setting that is no twin has no runs either
    }
  }
  return out;
}

std::vector<std::string> names_of(const StudyFile& study, const std::vector<StoredPoint>& rows) {
  std::vector<std::string> names;
  for (const Record& r : study.records) names.push_back(r.name.empty() ? r.result : r.name);
  if (!names.empty()) return names;
  std::set<std::string> all;
  for (const StoredPoint& row : rows)
    for (const auto& [name, value] : row.outcome.numbers) all.insert(name);
  return {all.begin(), all.end()};
}

/// The number that a record of what is expected belongs to; its name without the ending.
std::string expected_of(const std::string& name, const std::string& ending) {
  return name.ends_with(ending) ? name.substr(0, name.size() - ending.size()) : "";
}

/// Moves the records of what is expected to their numbers.
void attach_expected(std::vector<TableNumber>* numbers) {
  const auto find = [&](const std::string& name) {
    return std::find_if(numbers->begin(), numbers->end(),
                        [&](const TableNumber& n) { return n.name == name; });
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
  if (!std::isfinite(g.between)) return kNan;
  return noise > 0.0 ? g.between * g.between / noise : g.between > 0.0 ? 1e300 : 0.0;
}

}  // namespace

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
  std::string last = split(path).back();
  last = last.substr(0, last.find('['));
  const std::size_t at = last.rfind('_');
  const std::string end = at == std::string::npos ? "" : last.substr(at + 1);
  static const std::set<std::string> units = {"mm", "rad", "px", "s", "ms", "deg"};
  return units.contains(end) ? end : end == "dn" ? "DN" : "";
}

DesignTable design_table(const StudyFile& study, const std::vector<StoredPoint>& rows, double coverage) {
  DesignTable out;
  out.scattered = study.design == Design::latin_hypercube || study.design == Design::sobol;
  const auto seeds = static_cast<std::size_t>(study.noise_seeds);
  std::vector<const Settings*> settings;
  for (std::size_t i = 0; i < rows.size(); i += seeds) settings.push_back(&rows[i].point.settings);
  out.settings.resize(settings.size());
  add_axes(study, settings, &out);

  const std::vector<std::string> names = names_of(study, rows);
  std::vector<std::string> results = names;
  for (std::size_t k = 0; k < study.records.size(); ++k) results[k] = study.records[k].result;
  const auto truth = truths(study, settings, results);
  for (std::size_t k = 0; k < names.size(); ++k) {
    TableNumber number;
    number.name = display_name(names[k]);
    number.unit = unit_of(results[k]);
    number.is_time = results[k] == "acquisition.time_s";
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
  if (study.records.empty())
    std::stable_sort(out.numbers.begin(), out.numbers.end(), [](const TableNumber& a, const TableNumber& b) {
      if (a.is_error != b.is_error) return a.is_error;
      return (std::isnan(a.change) ? -1.0 : a.change) > (std::isnan(b.change) ? -1.0 : b.change);
    });
  return out;
}

}  // namespace fringetwin::study
