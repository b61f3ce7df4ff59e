// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/surface_roughness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace fringetwin::render {
namespace {

constexpr std::size_t kLeastSeen = 200;    // pixels
constexpr std::size_t kMostLooks = 20000;  // pixels that are looked at, for each direction
constexpr float kTimesMedian =
    3.0F;  // the median: 19 of 20 of a normal distribution's differences in two axes
constexpr float kMostAngleRad = 1.31F;  // 75 degrees: beyond, normals say nothing

// What a place differs from the middle of two others; none where they do not lie around it.
std::optional<Roughness> difference(const SurfacePlace& place, const SurfacePlace& a, const SurfacePlace& b) {
  const Eigen::Vector3f n = a.n + b.n;
  const float length = n.norm(), half = 0.5F * (a.p_mm - b.p_mm).norm();
  if (!(length > 0.0F) || !(half > 0.0F)) return std::nullopt;
  const float cosine = std::clamp(place.n.dot(n) / length, -1.0F, 1.0F);
  const float out = std::abs((place.p_mm - 0.5F * (a.p_mm + b.p_mm)).dot(n)) / length;
  return Roughness{std::acos(cosine), out / half};
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

std::map<int, Roughness> roughness_of(const SeenImage& seen, int step_px) {
  struct Found {
    std::vector<float> angles, outs;
  };
  std::map<int, Found> found;
  const std::size_t stride = std::max<std::size_t>(1, seen.at.size() / kMostLooks);
  for (const auto& [dx, dy] : {std::array{step_px, 0}, std::array{0, step_px}})
    for (std::size_t pixel = 0; pixel < seen.at.size(); pixel += stride) {
      const int x = static_cast<int>(pixel) % seen.width, y = static_cast<int>(pixel) / seen.width;
      if (x < dx || y < dy || x + dx >= seen.width || y + dy >= seen.height) continue;
      const std::size_t before = seen.pixel_of(x - dx, y - dy), after = seen.pixel_of(x + dx, y + dy);
      if (!seen.sees(pixel) || !seen.sees(before) || !seen.sees(after)) continue;
      const SurfacePlace& place = seen.place(pixel);
      if (seen.place(before).primitive != place.primitive || seen.place(after).primitive != place.primitive)
        continue;
      const auto d = difference(place, seen.place(before), seen.place(after));
      if (!d) continue;
      Found& of_surface = found[static_cast<int>(place.primitive)];
      of_surface.angles.push_back(d->angle_rad);
      of_surface.outs.push_back(d->out_of_plane);
    }
  std::map<int, Roughness> out;
  for (auto& [primitive, f] : found)
    if (f.angles.size() >= kLeastSeen) out[primitive] = {median(f.angles), median(f.outs)};
  return out;
}

SurfaceLimits limits_for(const SurfacePlace& place, const SurfaceLimits& limits,
                         const std::map<int, Roughness>& roughness) {
  const auto of_surface = roughness.find(static_cast<int>(place.primitive));
  if (of_surface == roughness.end()) return limits;
  return {std::min(limits.least_cosine,
                   std::cos(std::min(kTimesMedian * of_surface->second.angle_rad, kMostAngleRad))),
          std::max(limits.most_out_of_plane, kTimesMedian * of_surface->second.out_of_plane)};
}

}  // namespace fringetwin::render
