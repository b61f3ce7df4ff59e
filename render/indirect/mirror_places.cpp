// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/mirror_places.hpp"

#include <algorithm>
#include <cmath>

#include "twin/number/evenly_spread.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t kPlaces = 256;           // that are uploaded, at most
constexpr std::size_t kPlacesThatLook = 1024;  // for what the camera does not see, too
constexpr std::size_t kDirections = 32;

// Returns whether a material has a lobe so narrow that directions over the hemisphere hardly meet it.
bool has_narrow_lobe(const gpu::vec4& material) {
  constexpr float kWideAlpha = 0.2F;  // GGX's: 1/6 of the hemisphere's directions
  const float z = material.z,
              alpha = z < 0.0F ? -z : 1.0F / std::sqrt(2.0F * std::max(z, 0.5F));  // as mirror_way.glsl
  return material.y > 0.0F && alpha < kWideAlpha;
}

// Returns at most so many of some places, from all over them.
std::vector<SurfacePlace> some_of(const std::vector<SurfacePlace>& places, std::size_t most) {
  std::vector<SurfacePlace> some;
  for (const std::size_t i : evenly_spread(places.size(), most)) some.push_back(places[i]);
  return some;
}

// Returns what some places meet in directions over their hemispheres.
std::vector<SurfacePlace> met_from(TraceDevice& device, const TraceJob& job,
                                   std::vector<SurfacePlace> places) {
  const PassPlan no_sums;
  Gatherer gatherer(device, job, no_sums, kDirections, true);
  std::vector<SurfacePlace> met;
  for (std::size_t i = 0; i < places.size(); ++i) places[i].number = static_cast<float>(i);
  for (std::size_t first = 0; first < places.size(); first += gatherer.most_at_a_time()) {
    const Gathered from =
        gatherer.gather({&places[first], std::min(gatherer.most_at_a_time(), places.size() - first)});
    for (std::size_t i = 0; i < from.n; ++i) met.insert(met.end(), from.met(i).begin(), from.met(i).end());
  }
  return met;
}

}  // namespace

std::uint32_t upload_mirrors(TraceDevice& device, const TraceJob& job,
                             const std::vector<SurfacePlace>& seen) {
  if (!is_glossy(job) || std::ranges::none_of(job.scene.materials, has_narrow_lobe)) return 0;
  const auto shiny_of = [&](const std::vector<SurfacePlace>& places) {
    std::vector<SurfacePlace> shiny;
    std::ranges::copy_if(places, std::back_inserter(shiny), [&](const SurfacePlace& place) {
      return place.primitive >= 0.0F &&
             has_narrow_lobe(job.scene.materials[static_cast<std::size_t>(place.primitive)]);
    });
    return shiny;
  };
  std::vector<SurfacePlace> chosen =
      some_of(shiny_of(met_from(device, job, some_of(seen, kPlacesThatLook))), kPlaces / 2);
  std::ranges::copy(some_of(shiny_of(seen), kPlaces - chosen.size()), std::back_inserter(chosen));
  std::vector<gpu::vec4> texels;
  for (const SurfacePlace& place : chosen) {
    texels.push_back({place.p_mm.x(), place.p_mm.y(), place.p_mm.z(), place.primitive});
    texels.push_back({place.n.x(), place.n.y(), place.n.z(), 0.0F});
  }
  if (texels.empty()) return 0;
  device.fill(BIND_MIRRORS, texels);
  return static_cast<std::uint32_t>(chosen.size());
}

}  // namespace fringetwin::render
