// SPDX-License-Identifier: Apache-2.0
#include "render/transport_images.hpp"

#include <algorithm>

namespace fringetwin::render {

PairImages pair_images(Transport* transport, const PitchSlot& slot) {
  if (slot.harmonic == 1)
    return {&transport->cosine[slot.direction][slot.pitch], &transport->sine[slot.direction][slot.pitch]};
  auto& pair = transport->harmonics[slot.direction][slot.pitch][static_cast<std::size_t>(slot.harmonic) - 2];
  return {&pair.cosine, &pair.sine};
}

Transport empty_transport(const Twin& twin, const std::vector<PassPlan>& passes, const SeriesTable& series,
                          int width, int height) {
  Transport out;
  out.mean = ImageF(width, height);
  out.ambient = ImageF(width, height);
  out.object = Image<std::int32_t>(width, height, -1);
  out.series = series;
  const std::size_t n_directions = twin.fringes.directions.size();
  for (const PassPlan& pass : passes) {
    for (const PitchSlot& p : pass.pitches) {
      const std::size_t n_pitches = twin.fringes.directions[p.direction].pitches_px.size();
      out.cosine.resize(n_directions);
      out.sine.resize(n_directions);
      out.harmonics.resize(n_directions);
      out.cosine[p.direction].resize(n_pitches);
      out.sine[p.direction].resize(n_pitches);
      out.harmonics[p.direction].resize(n_pitches);
      auto& higher = out.harmonics[p.direction][p.pitch];
      if (p.harmonic > 1) higher.resize(std::max(higher.size(), static_cast<std::size_t>(p.harmonic) - 1));
      const PairImages images = pair_images(&out, p);
      *images.cosine = ImageF(width, height);
      *images.sine = ImageF(width, height);
    }
    for (const DirectSlot& d : pass.direct) {
      out.direct.resize(std::max(out.direct.size(), d.image + 1));
      out.direct[d.image] = ImageF(width, height);
    }
  }
  return out;
}

}  // namespace fringetwin::render
