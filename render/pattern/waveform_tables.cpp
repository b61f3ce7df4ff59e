// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/waveform_tables.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "render/pattern/waveform.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

using std::numbers::pi;
constexpr int kPartsOfASample = 64;  // of a period's table: an edge is 1/128 of a sample away at most

// A part of the projector's light, and the twin whose blur is that part's.
struct Spread {
  double share;
  Twin twin;
};

// Returns the parts that a halo makes of the light: all of it as it is without one.
std::vector<Spread> spreads_of(const Twin& twin) {
  const Projector& projector = *twin.projector;
  std::vector<Spread> parts{{1.0, twin}};
  if (!projector.has_halo()) return parts;
  for (const Halo& h : projector.halo) {
    parts.front().share -= h.share;
    if (h.share == 0.0) continue;
    parts.push_back({h.share, twin});
    parts.back().twin.projector->blur_px = std::hypot(projector.blur_px, h.sigma_px);
  }
  return parts;
}

// Adds a table's values, samples at first_px + i / per_px, to those of a finer one that begins there, too.
void add_interpolated(double share, const std::vector<double>& coarse, double coarse_per_px, double per_px,
                      std::vector<double>* fine) {
  for (std::size_t i = 0; i < fine->size(); ++i) {
    const double at = static_cast<double>(i) / per_px * coarse_per_px;
    const auto left = std::min(static_cast<std::size_t>(at), coarse.size() - 2);
    const double part = at - static_cast<double>(left);
    (*fine)[i] += share * ((1.0 - part) * coarse[left] + part * coarse[left + 1]);
  }
}

}  // namespace

std::vector<float> periodic_waveform(const Twin& twin, const PatternSpec& pattern, int samples) {
  FT_CHECK(!pattern.is_gray() && samples > 0, "one period exists of phase steps only");
  const DirectionFringes& d = twin.fringes.directions.at(pattern.direction);
  const auto p = static_cast<std::size_t>(pattern.pitch);
  // Between samples the shader interpolates: an edge at any place among them must leave the right mean.
  const bool has_edges =
      twin.fringes.waveform.kind == Waveform::Kind::levels && twin.projector->blur_px == 0.0;
  const int parts = has_edges ? kPartsOfASample : 1;
  std::vector<double> sums(samples, 0.0);
  for (const Spread& spread : spreads_of(twin)) {
    const EffectivePattern effective(spread.twin, pattern);
    for (int i = 0; i < samples; ++i) {
      double sum = 0.0;
      for (int j = 0; j < parts; ++j) {
        const double at = i + (has_edges ? (j + 0.5) / parts - 0.5 : 0.0);
        sum += effective(d.phase_origin_px.at(p) + d.pitches_px.at(p) * at / samples);
      }
      sums[i] += spread.share * (sum / parts);
    }
  }
  return {sums.begin(), sums.end()};
}

std::vector<float> axis_waveform(const Twin& twin, const PatternSpec& pattern, double samples_per_px,
                                 double* first_px) {
  FT_CHECK(samples_per_px > 0.0 && first_px != nullptr, "arguments of axis_waveform");
  const Axis axis = twin.fringes.directions.at(pattern.direction).axis;
  const int size = axis == Axis::x ? twin.projector->lens.width() : twin.projector->lens.height();
  const double margin_px = pattern_margin_px(*twin.projector), length_px = size + 2.0 * margin_px;
  *first_px = -0.5 - margin_px;
  std::vector<double> values(static_cast<std::size_t>(std::ceil(length_px * samples_per_px)) + 1, 0.0);
  for (const Spread& spread : spreads_of(twin)) {
    const EffectivePattern effective(spread.twin, pattern);
    // What is spread wider takes fewer samples, in the same ratio.
    const double per_px = samples_per_px * twin.projector->blur_px /
                          std::max(twin.projector->blur_px, spread.twin.projector->blur_px);
    const bool as_fine = spread.twin.projector->blur_px == twin.projector->blur_px;
    const std::vector<double> own = effective.table(
        *first_px, as_fine ? samples_per_px : per_px,
        as_fine ? values.size() : static_cast<std::size_t>(std::ceil(length_px * per_px)) + 2);
    if (as_fine)
      for (std::size_t i = 0; i < own.size(); ++i) values[i] += spread.share * own[i];
    else
      add_interpolated(spread.share, own, per_px, samples_per_px, &values);
  }
  return {values.begin(), values.end()};
}

std::vector<float> pixel_waveform(const Twin& twin, const PatternSpec& pattern, int* first_px) {
  const EffectivePattern effective(twin, pattern);
  const Axis axis = twin.fringes.directions.at(pattern.direction).axis;
  const int size = axis == Axis::x ? twin.projector->lens.width() : twin.projector->lens.height();
  const int margin = static_cast<int>(std::ceil(pattern_margin_px(*twin.projector)));
  *first_px = -margin;
  std::vector<float> values;
  for (int i = -margin; i < size + margin; ++i) values.push_back(static_cast<float>(effective(i)));
  return values;
}

std::vector<float> gap_waveform(const Projector& projector) {
  const double sigma = projector.blur_px, half = 0.5 * projector.pixel_fill;
  if (!projector.pixel_structure || projector.pixel_fill == 1.0 || sigma == 0.0) return {};
  constexpr int kSamples = 4096;
  std::vector<float> values;
  for (int i = 0; i <= kSamples + 1; ++i) {
    const double t = static_cast<double>(i % kSamples) / kSamples - 0.5;
    double lit = projector.pixel_fill;  // Fourier series of the raster; exp(-2 pi^2 1.5^2) = 5e-20
    for (int m = 1; m * sigma < 1.5; ++m)
      lit += 2.0 * std::sin(2.0 * pi * m * half) / (pi * m) * blur_attenuation(m, sigma, 1.0) *
             std::cos(2.0 * pi * m * t);
    values.push_back(static_cast<float>(lit / projector.pixel_fill));
  }
  return values;
}

}  // namespace fringetwin::render
