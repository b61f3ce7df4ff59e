// SPDX-License-Identifier: Apache-2.0
#include "render/trace/sum_targets.hpp"

#include <algorithm>

#include "render/pattern/transport_images.hpp"
#include "render/pattern/waveform.hpp"
#include "render/trace/pixel_blocks.hpp"

namespace fringetwin::render {

std::vector<SumTarget> sum_targets(const Twin& twin, const PassPlan& pass, bool first_pass, Transport* out) {
  // with a lamp the kernel adds up light, else hits
  const auto per_hit = static_cast<float>(twin.room.has_lamp() ? 1.0 : twin.projector->ambient);
  std::vector<SumTarget> targets{{first_pass ? &out->mean : nullptr, 1.0F},
                                 {first_pass ? &out->ambient : nullptr, per_hit}};
  for (const PitchSlot& p : pass.pitches) {
    const double pitch_px = twin.fringes.directions[p.direction].pitches_px[p.pitch];
    const auto blur = static_cast<float>(blur_attenuation(p.harmonic, twin.projector->blur_px, pitch_px));
    const bool no_image = p.harmonic > 1 && out->harmonics[p.direction][p.pitch].empty();
    const PairImages images = no_image ? PairImages{} : pair_images(out, p);
    targets.push_back({images.cosine, blur});
    targets.push_back({images.sine, blur});
  }
  for (const DirectSlot& d : pass.direct) targets.push_back({&out->direct[d.image], 1.0F});
  return targets;
}

void scatter_sums(const TraceJob& job, const std::vector<SumTarget>& targets, std::size_t first,
                  std::size_t n, const float* sums) {
  const std::size_t stride = n * BLOCK_PIXELS;
  const int width = job.out->mean.width, height = job.out->mean.height;
#pragma omp parallel for
  for (std::size_t b = 0; b < n; ++b) {
    const auto [x0, y0] = corner_of(job.blocks[first + b]);
    const int columns = std::min(BLOCK_WIDTH, width - x0);
    for (int y = 0; y < BLOCK_HEIGHT && y0 + y < height; ++y) {
      const std::size_t slot = b * BLOCK_PIXELS + y * BLOCK_WIDTH;
      for (std::size_t c = 0; c < targets.size(); ++c) {
        if (!targets[c].image) continue;
        const float* from = sums + c * stride + slot;
        float* to = &(*targets[c].image)(x0, y0 + y);
        for (int x = 0; x < columns; ++x) to[x] = from[x] * targets[c].factor;
      }
    }
  }
}

}  // namespace fringetwin::render
