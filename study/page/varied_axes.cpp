// SPDX-License-Identifier: Apache-2.0
#include "study/page/varied_axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "study/page/report_parts.hpp"
#include "study/plan/recorded_numbers.hpp"
#include "twin/number/parse_number.hpp"

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

/// Returns "camera.*.sensor.gain_dn" for the left's and the right's gain; of keys that differ more the first.
std::string label_of(const std::vector<std::string>& keys) {
  std::vector<std::string> common = split(keys[0]);
  for (const std::string& key : keys) {
    const std::vector<std::string> parts = split(key);
    if (parts.size() != common.size() || parts.back() != common.back())
      return fmt::format("{} and {} more", keys[0], keys.size() - 1);
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i] != common[i]) common[i] = "*";
  }
  return fmt::format("{}", fmt::join(common, "."));
}

double number_of(const std::string& text) { return parse_number<double>(text).value_or(kNan); }

/// Returns the values as names, numbers with as few digits as tell them apart, four at least.
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

/// Returns the axis of the values that occur: numbers in their order, else in the order of the design.
VariedAxis axis_of(const std::string& label, const std::string& brief, std::vector<std::string> texts,
                   bool log) {
  VariedAxis axis{label, brief, true, log, {}, {}};
  for (const std::string& text : texts) axis.numeric = axis.numeric && std::isfinite(number_of(text));
  std::vector<std::string> unique;
  std::set<std::string> seen;
  for (const std::string& text : texts)
    if (seen.insert(text).second) unique.push_back(text);
  if (axis.numeric)
    std::ranges::sort(unique,
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

/// Returns whether the first key's values stand for those of all keys: not where rows repeat them.
bool first_stands_for_all(const Variation& v) {
  return std::set<std::string>(v.values.begin(), v.values.end()).size() == v.values.size();
}

/// Returns the keys whose value is shown as a label: with rows those of the first key's kind.
std::string label_of(const Variation& v) {
  if (v.rows.empty()) return label_of(v.keys);
  std::vector<std::string> alike;
  for (const std::string& key : v.keys)
    if (split(key).back() == brief_of(v) && split(key).size() == split(v.keys[0]).size())
      alike.push_back(key);
  const std::size_t others = v.keys.size() - alike.size();
  return label_of(alike) + (others > 0 ? " and what goes with it" : "");
}

/// Returns the text of one [[vary]] in each setting.
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

void add_axis(const VariedAxis& axis, const std::vector<std::string>& texts, VariedSettings* varied) {
  if (axis.values.size() < 2) {
    varied->fixed.push_back(axis);
    return;
  }
  std::map<std::string, std::size_t> level;
  for (const std::string& text : texts) level.emplace(text, level.size());
  for (std::size_t s = 0; s < texts.size(); ++s) {
    std::size_t at = 0;
    if (axis.numeric) {
      const double value = number_of(texts[s]);
      at = static_cast<std::size_t>(std::ranges::lower_bound(axis.values, value) - axis.values.begin());
    } else {
      at = level.at(texts[s]);
    }
    varied->settings[s].level.push_back(at);
  }
  varied->axes.push_back(axis);
}

/// Returns tics at 1, 2, 5, 10 ... where whole decades are too few; none where they are enough.
std::vector<std::pair<double, std::string>> log_tics(double low, double high) {
  std::vector<std::pair<double, std::string>> out;
  if (high > 1000.0 * low) return out;
  for (double decade = std::pow(10.0, std::floor(std::log10(low))); decade <= high; decade *= 10.0)
    for (const double step : {1.0, 2.0, 5.0})
      if (const double v = step * decade; v >= 0.97 * low && v <= 1.03 * high)
        out.emplace_back(v, fmt::format("{:.4g}", v));
  return out;
}

}  // namespace

void add_joint_axis(const std::vector<Variation>& variations, const std::vector<const Settings*>& settings,
                    VariedSettings* varied) {
  std::vector<std::string> joined(settings.size());
  std::string label, brief;
  for (const Variation& v : variations) {
    const std::vector<std::string> texts = texts_of(v, settings);
    for (std::size_t s = 0; s < texts.size(); ++s)
      joined[s] += (joined[s].empty() ? "" : ", ") + plain_value(texts[s]);
    label += (label.empty() ? "" : ", ") + label_of(v);
    brief += (brief.empty() ? "" : ", ") + brief_of(v);
  }
  add_axis(axis_of(label, brief, joined, false), joined, varied);
}

void add_axes(const std::vector<Variation>& variations, const std::vector<const Settings*>& settings,
              VariedSettings* varied) {
  std::set<std::string> briefs;
  for (const Variation& v : variations) briefs.insert(brief_of(v));
  const bool distinct = briefs.size() == variations.size();
  for (const Variation& v : variations) {
    const std::vector<std::string> texts = texts_of(v, settings);
    const std::string label = label_of(v);
    add_axis(axis_of(label, distinct ? brief_of(v) : label, texts, v.range && v.range->log), texts, varied);
  }
}

std::string level_name(const std::string& toml) {
  const double value = number_of(toml);
  return std::isnan(value) ? plain_value(toml) : fmt::format("{:.8g}", value);
}

report::Plot axis_plot(const VariedAxis& a) {
  report::Plot plot{
      .x_label = with_unit(a.label, unit_of(a.label)), .log_x = a.log, .width_px = 540, .height_px = 330};
  const auto n = static_cast<double>(a.values.size());
  if (!a.numeric) {
    const std::size_t step = (a.names.size() + 15) / 16;
    for (std::size_t i = 0; i < a.names.size(); i += step)
      plot.x_tics.emplace_back(static_cast<double>(i), shortened(a.names[i]));
    plot.x_range = {-0.5, n - 0.5};
    return plot;
  }
  if (a.values.size() < 2) return plot;
  // The levels themselves as tics where they do not run into each other.
  const auto at = [&](double v) { return a.log ? std::log(v) : v; };
  const double whole = at(a.values.back()) - at(a.values.front());
  bool apart = a.values.size() <= 9;
  for (std::size_t i = 1; i < a.values.size(); ++i)
    apart = apart && at(a.values[i]) - at(a.values[i - 1]) > 0.07 * whole;
  if (apart)
    for (std::size_t i = 0; i < a.values.size(); ++i) plot.x_tics.emplace_back(a.values[i], a.names[i]);
  else if (a.log)
    plot.x_tics = log_tics(a.values.front(), a.values.back());
  const double margin = 0.03 * whole;
  const auto back = [&](double v) { return a.log ? std::exp(v) : v; };
  plot.x_range = {back(at(a.values.front()) - margin), back(at(a.values.back()) + margin)};
  return plot;
}

}  // namespace fringetwin::study
