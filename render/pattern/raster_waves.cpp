// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/raster_waves.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/pattern/unit_fringes.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::render {
namespace {

constexpr double kLeastTurns = 1e-9;  // per fringe: a wave that stands still has a pitch all the same

// Returns the sum of the sizes of a direction's waves, the largest of all directions.
double size_of_waves(const Twin& twin) {
  double most = 0.0;
  for (const DirectionFringes& d : twin.fringes.directions) {
    double sum = 0.0;
    for (const Harmonic& wave : d.raster.waves) sum += std::hypot(wave.cosine, wave.sine);
    most = std::max(most, sum);
  }
  return most;
}

// Returns the same, over the first harmonic of the fringes of least contrast.
double share_of_waves(const Twin& twin) {
  double least = 1.0;
  for (const DirectionFringes& d : twin.fringes.directions)
    for (const double contrast : d.contrast) least = std::min(least, contrast);
  return size_of_waves(twin) / (twin.fringes.amplitude * least);
}

bool is_there(const Harmonic& wave) { return wave != Harmonic{}; }

}  // namespace

RasterWave raster_wave(const Twin& twin, const DirectionFringes& direction, std::size_t pitch,
                       std::size_t wave) {
  const Raster& raster = direction.raster;
  const Lens& lens = twin.projector->lens;
  const int order = raster.first_order + static_cast<int>(wave);
  const double pitch_px = direction.pitches_px[pitch], taken = raster.turns_taken(order, pitch_px),
               middle_px = middle_of_raster_px(direction.axis == Axis::x ? lens.width() : lens.height());
  return {order, order - taken * pitch_px / raster.pitch_px,
          kTwoPi * taken * (middle_px - direction.phase_origin_px[pitch]) / raster.pitch_px};
}

Twin showing_waves(const Twin& twin) {
  std::vector<DirectionFringes> directions;
  for (const DirectionFringes& d : twin.fringes.directions) {
    if (!d.raster.has_any()) continue;
    for (std::size_t p = 0; p < d.pitches_px.size(); ++p) {
      DirectionFringes waves{d.axis, {}, {}, {}};
      for (std::size_t k = 0; k < d.raster.waves.size(); ++k) {
        if (!is_there(d.raster.waves[k])) continue;
        waves.pitches_px.push_back(d.pitches_px[p] /
                                   std::max(std::abs(raster_wave(twin, d, p, k).turns), kLeastTurns));
        waves.phase_origin_px.push_back(d.phase_origin_px[p]);
      }
      directions.push_back(std::move(waves));
    }
  }
  Twin view = showing_fringes(twin, std::move(directions));
  view.projector->halo.clear();
  return view;
}

Sampling sampling_of_waves(const Twin& twin, const Sampling& sampling) {
  constexpr double kMostPhaseError = 0.1, kMostGrayError = 0.02;
  Sampling out = sampling;
  out.phase_error_rad = std::min(sampling.phase_error_rad / share_of_waves(twin), kMostPhaseError);
  out.gray_error = std::min(sampling.gray_error * kUnitLevel / size_of_waves(twin), kMostGrayError);
  return out;
}

void take_waves(const Twin& twin, Transport seen, Transport& transport) {
  std::size_t next = 0;
  transport.waves.assign(twin.fringes.directions.size(), {});
  for (std::size_t d = 0; d < twin.fringes.directions.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    if (!direction.raster.has_any()) continue;
    for (std::size_t p = 0; p < direction.pitches_px.size(); ++p, ++next) {
      std::vector<Transport::Pair>& pairs = transport.waves[d].emplace_back();
      pairs.resize(direction.raster.waves.size());
      for (std::size_t k = 0, traced = 0; k < pairs.size(); ++k)
        if (is_there(direction.raster.waves[k])) {
          pairs[k] = {std::move(seen.cosine[next][traced]), std::move(seen.sine[next][traced])};
          ++traced;
        }
    }
  }
  transport.rays += seen.rays;
  transport.repeated_dispatches += seen.repeated_dispatches;
  if (!seen.estimate) transport.estimate.reset();
  if (!transport.estimate) return;
  const double share = size_of_waves(twin) / kUnitLevel;
  // a wave that pixels leave nothing of has no phase, and its error is no larger than itself
  transport.estimate->phase_rad += share_of_waves(twin) * std::min(1.0, seen.estimate->phase_rad);
  transport.estimate->gray += share * seen.estimate->gray;
  transport.estimate->gray_inside += share * seen.estimate->gray_inside;
}

// The wave of order h of an image that lies s further, pixels and all, is a cos t + b sin t, t = 2 pi (turns
// (x - s - origin)/p + h n/N) + ahead; the sums are of cos and sin of 2 pi |turns| (x - origin)/p.
std::vector<WaveTerm> waves_of_image(const Twin& twin, const PatternSpec& spec, std::size_t image) {
  const DirectionFringes& d = twin.fringes.directions[static_cast<std::size_t>(spec.direction)];
  const auto p = static_cast<std::size_t>(spec.pitch);
  std::vector<WaveTerm> terms;
  if (!d.raster.has_any()) return terms;
  for (std::size_t i = 0; i < d.raster.waves.size(); ++i) {
    const Harmonic& wave = d.raster.waves[i];
    if (!is_there(wave)) continue;
    const auto [order, turns, ahead] = raster_wave(twin, d, p, i);
    const double per_px = turns / d.pitches_px[p];
    const double angle = ahead + kTwoPi * (order * static_cast<double>(spec.step) / twin.fringes.steps -
                                           per_px * twin.projector->image_shift_px(image));
    const double c = std::cos(angle), s = std::sin(angle);
    double left = d.contrast_of(p) * d.raster.left_by_pixels(per_px);
    if (twin.projector->has_halo()) left *= twin.projector->halo_attenuation(std::abs(per_px));
    terms.push_back({i, left * (wave.cosine * c + wave.sine * s),
                     std::copysign(left, turns) * (wave.cosine * s - wave.sine * c)});
  }
  return terms;
}

}  // namespace fringetwin::render
