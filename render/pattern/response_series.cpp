// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/response_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/pattern/waveform.hpp"
#include "render/shaders/shared.h"

namespace fringetwin::render {
namespace {

constexpr int kExamined = 64;  // harmonics looked at
static_assert(kHighestHarmonic <= kMostPairs && kMostPairs <= MAX_PITCHES);
// Costs of a pair, of a pitch's cosine and sine, and of the trace of a pass, in units of one direct
// evaluation, on lavapipe with an analytic scene. A mesh's trace costs more, so that fewer passes count even
// more there.
constexpr double kPairCost = 0.4, kFundamentalCost = 0.6, kPassCost = 8.0;
constexpr double kShareOfPhaseError = 0.1;

/// Estimates the cost of the trace in direct evaluations per sample, passes included (docs/PHYSICS.md).
double series_cost(const Twin& twin, const SeriesTable& table) {
  double cost = 0.0;
  std::size_t pair_passes = 0, pairs = kMostPairs, images = 0;
  for (const PatternSpec& p : expand_sequence(twin.fringes)) {
    const bool carried = p.kind == PatternSpec::Kind::phase_step && !table[p.direction][p.pitch].a.empty();
    images += carried ? 0 : 1;
  }
  for (const auto& direction : table)
    for (const PhaseSeries& series : direction) {
      if (series.a.size() < 2) continue;
      const std::size_t harmonics = series.a.size() - 1;
      if (pairs + harmonics > kMostPairs) {
        ++pair_passes;
        pairs = 0;
      }
      pairs += harmonics;
      cost += kFundamentalCost + kPairCost * static_cast<double>(harmonics);
    }
  const std::size_t passes = std::max<std::size_t>({1, pair_passes, (images + MAX_DIRECT - 1) / MAX_DIRECT});
  return cost + static_cast<double>(images) + kPassCost * static_cast<double>(passes);
}

/// Returns the sum over k > `harmonics` of what a blur leaves of amplitudes 1/k; infinite where it ends late.
double left_beyond(int harmonics, double sigma_px, double pitch_px) {
  constexpr int kMostTerms = 4096;
  double sum = 0.0;
  for (int k = harmonics + 1; k <= harmonics + kMostTerms; ++k) {
    const double left = blur_attenuation(k, sigma_px, pitch_px);
    if (left < 1e-20) return sum;
    sum += left / k;
  }
  return std::numeric_limits<double>::infinity();
}

/// Scales all that varies with the phase; 1 changes no bit.
void give_contrast(double contrast, PhaseSeries* series) {
  if (contrast == 1.0) return;
  for (std::size_t k = 1; k < series->a.size(); ++k) series->a[k] *= contrast;
  for (std::size_t k = 1; k < series->b.size(); ++k) series->b[k] *= contrast;
}

/// Takes from each harmonic what the halo does; without one no bit changes.
void give_halo(const Projector& projector, double pitch_px, PhaseSeries* series) {
  if (!projector.has_halo()) return;
  for (std::size_t k = 1; k < series->a.size(); ++k) {
    const double left = projector.halo_attenuation(static_cast<double>(k) / pitch_px);
    series->a[k] *= left;
    if (!series->b.empty()) series->b[k] *= left;
  }
}

/// Returns harmonics of the orders from `lowest` on that fringes of a pitch have besides, as a series of n
/// coefficients with the pitch's contrast and what the halo leaves.
PhaseSeries series_besides(const Twin& twin, const DirectionFringes& direction, std::size_t pitch,
                           const Harmonics& list, std::size_t lowest, std::size_t n) {
  PhaseSeries series;
  series.a.assign(n, 0.0);
  series.b = series.a;
  for (std::size_t k = lowest; k < std::min(n, list.size() + lowest); ++k)
    series.a[k] = list[k - lowest].cosine, series.b[k] = list[k - lowest].sine;
  give_contrast(direction.contrast_of(pitch), &series);
  give_halo(*twin.projector, direction.pitches_px[pitch], &series);
  return series;
}

}  // namespace

PhaseSeries short_series(const Projector& projector, const Fringes& fringes, double pitch_px,
                         double relative_bound, int most, const Harmonics& added,
                         const std::vector<double>& more) {
  const int harmonics = count_harmonics(projector, fringes, pitch_px, relative_bound, added, more);
  if (harmonics > most) return {};
  return fringe_series(projector.response, fringes, added, harmonics);
}

SeriesTable largest_series(const Twin& twin, const SeriesTable& series) {
  SeriesTable out = series;
  for (std::size_t d = 0; d < out.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    const std::vector<double> more = twin.fringes.more_harmonics(direction);
    for (std::size_t p = 0; p < out[d].size(); ++p) {
      PhaseSeries added;
      added.a.assign(out[d][p].a.size(), 0.0);
      for (std::size_t k = 2; k < std::min(added.a.size(), more.size() + 2); ++k) added.a[k] = more[k - 2];
      give_contrast(direction.contrast_of(p), &added);
      give_halo(*twin.projector, direction.pitches_px[p], &added);
      for (std::size_t k = 2; k < added.a.size(); ++k) {
        const double size = out[d][p].size(k);
        if (!out[d][p].b.empty()) out[d][p].b[k] = 0.0;
        out[d][p].a[k] = size + added.a[k];
      }
    }
  }
  return out;
}

SeriesOfField field_series(const Twin& twin, const SeriesTable& series) {
  SeriesOfField out;
  for (std::size_t d = 0; d < series.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    out.emplace_back(series[d].size());
    for (std::size_t p = 0; p < series[d].size(); ++p)
      for (const Harmonics& term : direction.harmonics_field)
        out[d][p].push_back(series_besides(twin, direction, p, term, 2, series[d][p].a.size()));
  }
  return out;
}

PhaseSeries series_of_image(const Twin& twin, const PhaseSeries& of_pitch, const PatternSpec& spec,
                            std::size_t image) {
  const Harmonics& own = twin.fringes.harmonics_of_image(image);
  PhaseSeries out = of_pitch;
  if (own.empty()) return out;
  const PhaseSeries added =
      series_besides(twin, twin.fringes.directions[static_cast<std::size_t>(spec.direction)],
                     static_cast<std::size_t>(spec.pitch), own, 1, out.a.size());
  out.b.resize(out.a.size(), 0.0);
  for (std::size_t k = 1; k < out.a.size(); ++k) out.a[k] += added.a[k], out.b[k] += added.b[k];
  return out;
}

int count_harmonics(const Projector& projector, const Fringes& fringes, double pitch_px,
                    double relative_bound, const Harmonics& added, const std::vector<double>& more) {
  const bool sine = fringes.waveform.kind == Waveform::Kind::sine;
  if (is_linear(projector.response) && sine && added.empty() && more.empty()) return 1;
  const PhaseSeries series = fringe_series(projector.response, fringes, added, kExamined);
  const double blur_px = projector.least_blur_px();
  std::vector<double> size;
  for (int k = 0; k <= kExamined; ++k) {
    const auto i = static_cast<std::size_t>(k - 2);  // wraps for the first two
    const double all = series.size(k) + (i < more.size() ? more[i] : 0.0);
    size.push_back(all * blur_attenuation(k, blur_px, pitch_px));
  }
  double dropped = 0.0;
  if (sine) {
    // Beyond: coefficients fall at least as 1/k^2 (the response is continuous), so all harmonics after 64
    // sum up to what 33 ... 64 do; twice that is safe.
    for (int k = kExamined / 2 + 1; k <= kExamined; ++k) dropped += 2.0 * size[k];
  } else {
    dropped = total_variation(projector.response, fringes) / std::numbers::pi *
              left_beyond(kExamined, blur_px, pitch_px);
  }
  int harmonics = kExamined;
  while (harmonics > 1 && dropped + size[harmonics] <= relative_bound * size[1]) dropped += size[harmonics--];
  return harmonics;
}

SeriesTable choose_series(const Twin& twin, PatternMethod method, std::optional<double> phase_error_rad) {
  const double bound = kShareOfPhaseError * phase_error_rad.value_or(twin.render.phase_error_rad);
  SeriesTable direct, carried;
  const bool pure = throws_pure_cosines(twin);
  for (const DirectionFringes& d : twin.fringes.directions) {
    direct.emplace_back(d.pitches_px.size());
    carried.emplace_back(d.pitches_px.size());
    if (twin.projector->pixel_structure || twin.fringes.steps == 0) continue;
    for (std::size_t p = 0; p < d.pitches_px.size(); ++p) {
      carried.back()[p] = short_series(*twin.projector, twin.fringes, d.pitches_px[p], bound, kMostPairs,
                                       d.harmonics_of(p), twin.fringes.more_harmonics(d));
      give_contrast(d.contrast_of(p), &carried.back()[p]);
      give_halo(*twin.projector, d.pitches_px[p], &carried.back()[p]);
    }
  }
  // Added harmonics cost no pairs where they are formed from the fundamental (formed_harmonics.hpp).
  const bool added_alone = is_linear(twin.projector->response) && !twin.projector->pixel_structure &&
                           twin.fringes.steps > 0 && twin.fringes.waveform.kind == Waveform::Kind::sine;
  // The direct way of a defocused pattern is a quadrature for each step and sample, and so is that of light
  // below surfaces; a blur that varies has none.
  const bool carry =
      pure || method == PatternMethod::harmonics ||
      (method == PatternMethod::automatic &&
       (added_alone || twin.fringes.has_harmonics_field() || twin.fringes.has_image_harmonics() ||
        twin.projector->optics || twin.projector->has_blur_field() || twin.has_subsurface() ||
        series_cost(twin, carried) < series_cost(twin, direct)));
  return carry ? carried : direct;
}

}  // namespace fringetwin::render
