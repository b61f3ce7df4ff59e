// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/transport_images.hpp"

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
  out.object = Image<std::int32_t>(width, height, -1);
  out.series = series;
  const std::size_t n_directions = twin.fringes.directions.size();
  for (const PassPlan& pass : passes) {
    for (const PitchSlot& p : pass.pitches) {
      const std::size_t n_pitches = twin.fringes.directions[p.direction].pitches_px.size();
      out.cosine.resize(n_directions);
      out.sine.resize(n_directions);
      out.harmonics.resize(n_directions);
      out.own_harmonics.resize(n_directions);
      out.cosine[p.direction].resize(n_pitches);
      out.sine[p.direction].resize(n_pitches);
      out.harmonics[p.direction].resize(n_pitches);
      out.own_harmonics[p.direction].resize(n_pitches);
      auto& higher = out.harmonics[p.direction][p.pitch];
      if (p.harmonic > 1) higher.resize(std::max(higher.size(), static_cast<std::size_t>(p.harmonic) - 1));
    }
    for (const DirectSlot& d : pass.direct) out.direct.resize(std::max(out.direct.size(), d.image + 1));
  }
  std::vector<ImageF*> images{&out.mean, &out.ambient};
  for (const PassPlan& pass : passes) {
    for (const PitchSlot& p : pass.pitches) {
      const PairImages pair = pair_images(&out, p);
      images.insert(images.end(), {pair.cosine, pair.sine});
    }
    for (const DirectSlot& d : pass.direct) images.push_back(&out.direct[d.image]);
  }
  make_blank(images, width, height);
  return out;
}

void make_blank(const std::vector<ImageF*>& images, int width, int height) {
  const std::size_t n = static_cast<std::size_t>(width) * height;
  for (ImageF* image : images) {
    image->width = width;
    image->height = height;
    image->data.clear();
    image->data.reserve(n);
  }
#pragma omp parallel for
  for (std::size_t i = 0; i < images.size(); ++i) images[i]->data.resize(n);  // does not throw any more
}

}  // namespace fringetwin::render
