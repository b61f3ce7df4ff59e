// SPDX-License-Identifier: Apache-2.0
#include "capture/genicam/genicam_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "twin/base/nearest_word.hpp"
#include "twin/base/paths.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::capture {
namespace {

using Kind = GenicamFeature::Kind;

constexpr double kSameNumber = 1e-3;  ///< relative, where a camera names no step: it rounds to its own
constexpr std::size_t kNamesShown = 12;

/// Returns "true" or "false" of what users write; "" for anything else.
std::string boolean_of(const std::string& text) {
  const std::string word = lower_case(text);
  if (word == "1" || word == "on" || word == "true") return "true";
  if (word == "0" || word == "off" || word == "false") return "false";
  return "";
}

/// Returns the names of a family: "gain" asks for Gain, GainRaw and GainAuto, of which did_you_mean() says
/// one.
std::vector<std::string> names_like(const std::vector<std::string>& all, const std::string& name) {
  const std::string wanted = lower_case(name);
  std::vector<std::string> like;
  for (std::size_t n = wanted.size(); n >= 3 && like.empty(); --n)  // the longest beginning that any has
    for (const std::string& other : all)
      if (lower_case(other).find(wanted.substr(0, n)) != std::string::npos) like.push_back(other);
  if (like.size() > kNamesShown) like.resize(kNamesShown);
  return like;
}

/// Looked for by name: some cameras' descriptions leave features out of their own table of contents.
const std::vector<std::string> kKnownFeatures = {
    "Gain",         "GainRaw",   "GainAuto",         "BlackLevel",    "BlackLevelRaw",   "BlackLevelAuto",
    "ExposureAuto", "GammaAuto", "BalanceWhiteAuto", "FocusAuto",     "ExposureTime",    "ExposureTimeAbs",
    "Gamma",        "HueAuto",   "SaturationAuto",   "SharpnessAuto", "WhiteBalanceAuto"};

std::vector<std::string> all_names(GenicamDevice& device) {
  std::vector<std::string> names = device.feature_names();
  for (const std::string& name : kKnownFeatures)
    if (std::ranges::find(names, name) == names.end() && device.feature(name).there()) names.push_back(name);
  return names;
}

}  // namespace

std::string range_text(const GenicamFeature& feature) {
  switch (feature.kind) {
    case Kind::choice:
      return fmt::format("{}", fmt::join(feature.choices, ", "));
    case Kind::boolean:
      return "false, true";
    case Kind::integer:
    case Kind::number: {
      const bool steps = feature.step > (feature.kind == Kind::integer ? 1.0 : 0.0);
      return fmt::format("{:.10g}...{:.10g}", feature.min, feature.max) +
             (steps ? fmt::format(" in steps of {:.6g}", feature.step) : "") +
             (feature.unit.empty() ? "" : " " + feature.unit);
    }
    case Kind::text:
      return "any text";
    default:
      return "nothing";
  }
}

std::string GenicamSettings::own_name(const std::string& name) const {
  if (device_.feature(name).there()) return name;
  const std::vector<std::string> all = all_names(device_);
  for (const std::string& other : all)
    if (lower_case(other) == lower_case(name) && device_.feature(other).there()) return other;
  const std::vector<std::string> like = names_like(all, name);
  const std::string close = did_you_mean(name, all);  // letters that were exchanged or left out
  throw refusal("has no feature '" + name + "' now",
                !like.empty()    ? fmt::format("it has {}", fmt::join(like, ", "))
                : !close.empty() ? close
                                 : fmt::format("none of its {} features has a name like it", all.size()));
}

std::string GenicamSettings::first_of(const std::vector<std::string>& names) const {
  for (const std::string& name : names)
    if (device_.feature(name).there()) return name;
  return "";
}

double GenicamSettings::number(const std::string& name) const {
  const GenicamFeature feature = device_.feature(name);
  const auto value = parse_number<double>(feature.value);
  if (!feature.readable || !value) throw refusal(fmt::format("feature '{}' cannot be read", name));
  return *value;
}

/// Returns the value as the camera takes it.
std::string GenicamSettings::accepted(const std::string& name, const GenicamFeature& feature,
                                      const std::string& value) const {
  const auto refuse = [&](const std::string& why) {
    return refusal(fmt::format("feature '{}' was asked for {} {}", name, value, why),
                   "it takes " + range_text(feature));
  };
  if (feature.is_number()) {
    const auto number = parse_number<double>(value);
    if (!number || (feature.kind == Kind::integer && *number != std::floor(*number)))
      throw refuse(feature.kind == Kind::integer ? "which is no whole number" : "which is no number");
    const double slack = 1e-9 * std::max(std::abs(feature.min), std::abs(feature.max));
    if (feature.max > feature.min && (*number < feature.min - slack || *number > feature.max + slack))
      throw refuse("which is out of range");
    return feature.kind == Kind::integer ? fmt::format("{:.0f}", *number) : value;
  }
  if (feature.kind == Kind::boolean) {
    const std::string word = boolean_of(value);
    if (word.empty()) throw refuse("which is neither true nor false");
    return word;
  }
  if (feature.kind == Kind::choice) {
    for (const std::string& choice : feature.choices)
      if (lower_case(choice) == lower_case(value)) return choice;
    throw refuse("which it does not have now");
  }
  return value;
}

bool GenicamSettings::same(const GenicamFeature& now, const std::string& asked) const {
  if (now.kind == Kind::boolean) return boolean_of(now.value) == asked;
  if (!now.is_number()) return now.value == asked;
  const auto got = parse_number<double>(now.value), wanted = parse_number<double>(asked);
  if (!got || !wanted) return false;
  if (now.kind == Kind::integer) return *got == *wanted;
  const double slack = now.step > 0.0 ? 0.5 * now.step : kSameNumber * std::abs(*wanted);
  return std::abs(*got - *wanted) <= slack + 1e-9 * std::abs(*wanted);
}

void GenicamSettings::set(const std::string& name, const std::string& value) const {
  const GenicamFeature feature = device_.feature(name);
  if (!feature.there()) throw refusal("has no feature '" + name + "' now");
  if (feature.kind == Kind::command) return execute(name);
  const std::string text = accepted(name, feature, value);
  if (!feature.writable && feature.readable && same(feature, text)) return;
  if (!feature.writable)
    throw refusal(fmt::format("feature '{}' was asked for {} but cannot be changed now", name, value),
                  feature.readable ? "it is " + feature.value : "");
  std::string fault;
  if (!device_.set(name, text, &fault))
    throw refusal(fmt::format("feature '{}' was asked for {} and refused it: {}", name, value, fault),
                  "it takes " + range_text(feature));
  verify(name, text);
}

void GenicamSettings::set(const std::string& name, double value) const {
  set(name, fmt::format("{}", value));
}

void GenicamSettings::set_where_there(const std::string& name, const std::string& value) const {
  const GenicamFeature feature = device_.feature(name);
  if (feature.there() && feature.writable) set(name, value);
}

void GenicamSettings::execute(const std::string& command) const {
  std::string fault;
  if (!device_.execute(command, &fault))
    throw refusal(fmt::format("command '{}' failed: {}", command, fault));
}

void GenicamSettings::verify(const std::string& name, const std::string& value) const {
  const GenicamFeature now = device_.feature(name);
  if (!now.readable) return;
  if (!same(now, accepted(name, now, value)))
    throw refusal(fmt::format("feature '{}' was asked for {} but has {}", name, value, now.value),
                  "it takes " + range_text(now));
}

std::vector<std::string> GenicamSettings::turn_off_automatics(const std::set<std::string>& kept) const {
  std::vector<std::string> automatics;
  for (const std::string& name : all_names(device_)) {
    if (!name.ends_with("Auto")) continue;
    const GenicamFeature feature = device_.feature(name);
    if (feature.kind != Kind::choice) continue;
    automatics.push_back(name);
    if (kept.contains(name) || feature.value == "Off") continue;
    if (feature.has_choice("Off"))
      set(name, "Off");
    else if (feature.writable)
      throw refusal(
          fmt::format("feature '{}' cannot be turned off", name),
          fmt::format("it has {}; name it with --control to record all the same", range_text(feature)));
  }
  return automatics;
}

std::map<std::string, std::string> GenicamSettings::provenance(const std::vector<std::string>& names) const {
  std::map<std::string, std::string> values;
  for (const std::string& name : names)
    if (const GenicamFeature feature = device_.feature(name); feature.readable && !feature.value.empty())
      values["control." + name] = feature.value + (feature.unit.empty() ? "" : " " + feature.unit);
  return values;
}

}  // namespace fringetwin::capture
