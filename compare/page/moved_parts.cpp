// SPDX-License-Identifier: Apache-2.0
#include "compare/page/moved_parts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace fringetwin::compare {
namespace {

constexpr double kSigmas = 4.0;  ///< a dozen estimates: one search in a thousand has one beyond by chance

/// Returns what stands before the first dot: "projector" of "projector.turn_rad.y".
std::string thing_of(const CauseParameter& p) { return p.name.substr(0, p.name.find('.')); }
/// Returns the name without its axis: "projector.turn_rad" of "projector.turn_rad.y".
std::string place_of(const CauseParameter& p) {
  const std::size_t dot = p.name.rfind('.');
  return dot + 2 == p.name.size() ? p.name.substr(0, dot) : p.name;
}
bool is_off(const CauseParameter& p) {
  return p.sigma > 0.0 && std::abs(p.estimate - p.twin) > kSigmas * p.sigma;
}

std::vector<std::string> moved_of(const Causes& causes, const std::string& group) {
  std::vector<std::string> places;
  const auto row = std::ranges::find(causes.rows, group, &CauseRow::group);
  if (row == causes.rows.end()) return places;
  for (const CauseParameter& p : row->parameters) {
    // turn and shift of a thing are hardly told apart: both, where one is off
    const bool moved = std::ranges::any_of(row->parameters, [&](const CauseParameter& other) {
      return thing_of(other) == thing_of(p) && is_off(other);
    });
    if (moved && std::ranges::find(places, place_of(p)) == places.end()) places.push_back(place_of(p));
  }
  return places;
}

}  // namespace

std::vector<std::string> moved_parts(const Causes& causes) {
  std::vector<std::string> parts = moved_of(causes, "rig");
  const std::vector<std::string> objects = moved_of(causes, "pose");
  if (parts.empty() || objects.empty()) return {};
  std::ranges::copy(objects, std::back_inserter(parts));
  return parts;
}

}  // namespace fringetwin::compare
