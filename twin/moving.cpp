// SPDX-License-Identifier: Apache-2.0
#include "twin/moving.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace fringetwin {
namespace {

bool moves(const Object& object) {
  return std::ranges::any_of(object.motion, [](double way) { return way != 0.0; });
}

}  // namespace

bool has_motion(const Twin& twin) { return std::ranges::any_of(twin.objects, moves); }

Twin twin_at_image(const Twin& twin, double image, std::size_t n_images) {
  const double gone = n_images < 2 ? 0.0 : image / static_cast<double>(n_images - 1) - 0.5;
  Twin out = twin;
  for (Object& object : out.objects) {
    if (moves(object))
      std::visit(
          [&]<class S>(S& shape) {
            const std::vector<Motion<S>> ways = motions(shape);
            for (std::size_t k = 0; k < std::min(ways.size(), object.motion.size()); ++k)
              ways[k].move_by(shape, gone * object.motion[k]);
            make_units(shape);
          },
          object.shape);
    object.motion.clear();
  }
  return out;
}

std::vector<MotionKey> motion_keys(const Shape& shape) {
  std::vector<MotionKey> keys;
  std::visit(
      [&](const auto& s) {
        std::size_t at = 0;
        for (const auto& way : motions(s)) {
          const std::string key = way.name.substr(0, way.name.find('.'));
          const auto known = std::ranges::find(keys, key, &MotionKey::key);
          (known == keys.end() ? keys.emplace_back(MotionKey{key, {}}) : *known).at.push_back(at++);
        }
      },
      shape);
  return keys;
}

std::string motion_text(const Object& object) {
  std::vector<std::string> parts;
  for (const MotionKey& key : motion_keys(object.shape)) {
    std::vector<double> ways;
    for (const std::size_t at : key.at) ways.push_back(at < object.motion.size() ? object.motion[at] : 0.0);
    if (std::ranges::all_of(ways, [](double way) { return way == 0.0; })) continue;
    parts.push_back(ways.size() == 1 ? fmt::format("{} = {}", key.key, ways[0])
                                     : fmt::format("{} = [{}]", key.key, fmt::join(ways, ", ")));
  }
  return parts.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(parts, ", "));
}

}  // namespace fringetwin
