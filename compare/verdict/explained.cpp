// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/explained.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

/// Returns whether a pixel has fringes to compare: neither saturated nor weak, and more than noise, which may
/// pass a low min_modulation_dn by chance. Coverage asks for less: a saturated pixel is seen, and should have
/// been measured. Doubts of the description ask the gray values, as no decode can be believed then.
bool has_fringes(const CameraDecode& decode, std::size_t i) {
  constexpr double kSigmas = 4.0;
  if ((decode.flags.data[i] & measure::kUnseen) != 0) return false;
  return std::ranges::all_of(decode.directions, [i](const DirectionDecode& d) {
    const auto pitch = std::min(static_cast<std::size_t>(d.finest), d.amplitude_dn.size() - 1);
    return d.amplitude_dn.empty() ||
           static_cast<double>(d.amplitude_dn[pitch].data[i]) >= kSigmas * d.noise_dn;
  });
}

}  // namespace

double allowed_for(double n, double known_to) { return kCoverage * std::sqrt(2.0 / n + known_to * known_to); }

double allowed_above(double n, double known_to) {
  const double variance = 2.0 / (9.0 * n);
  const double by_chance = std::pow(1.0 - variance + kCoverage * std::sqrt(variance), 3) - 1.0;
  return std::hypot(by_chance, kCoverage * known_to);
}

RenderingError rendering_error(const Camera& camera, const std::vector<RenderNote>& notes, double gain_dn) {
  for (const RenderNote& note : notes)
    if (note.camera == camera.name) {
      const double of_full_scale = camera.sensor.max_dn() * gain_dn / camera.sensor.gain_dn;
      const double with_edges = note.gray_error.value_or(0.0);
      return {note.gray_inside_error.value_or(with_edges) * of_full_scale, note.phase_error_rad.value_or(0.0),
              note.gray_error.has_value(), with_edges * of_full_scale};
    }
  return {};
}

SeenPixels seen_pixels(const CameraDecode* real, const CameraDecode* simulated) {
  SeenPixels out;
  if (!real || !simulated) return out;
  for (std::size_t i = 0; i < real->flags.size(); ++i) {
    if (real->flags.data[i] == measure::kValid && simulated->flags.data[i] == measure::kValid) ++out.both;
    if (has_fringes(*real, i) || has_fringes(*simulated, i)) ++out.either;
  }
  return out;
}

OwnLightSums own_light_sums(const GrayPair& pair, const OwnOfPixels& own, const GrayNoise& noise,
                            std::size_t i) {
  OwnLightSums sums;
  if (!own.kinds.any()) return sums;
  for (const int image : own.images)
    if (const double y = pair.real_at(image, i); y < pair.real->saturation_dn())
      sums.add(pair.irradiance_at(image, i), y, noise.variance(y));
  return sums;
}

ShapeInView shape_in_budget(const ShapeInView& shape, const OwnOfPixels& own) {
  ShapeInView out = shape;
  if (own.kinds.factor && own.from_here) out.shades = false;  // one from elsewhere has not seen this noise
  return out;
}

std::vector<BudgetLine> noise_lines(const GrayNoise& noise, double noise_dn2, const RenderingError& rendering,
                                    double scatter_dn2) {
  const double rounding_dn2 = std::min(noise.rounding_dn2(), noise_dn2);
  return {{"noise: " + noise.source(), noise_dn2 - rounding_dn2},
          {"quantisation", rounding_dn2},
          rendering.line(rendering.gray_dn * rendering.gray_dn + scatter_dn2)};
}

ExplainedRow not_compared(const std::string& quantity, const std::string& region, const std::string& why) {
  ExplainedRow row;
  row.quantity = quantity;
  row.region = region;
  row.worsen(kNotCompared, why);
  return row;
}

void hold_against_noise(const std::vector<NoiseRow>& noise, std::vector<ExplainedRow>& rows) {
  for (ExplainedRow& row : rows) {
    if (!row.states_noise) continue;
    const NoiseRow* refuting = nullptr;
    for (const NoiseRow& n : noise) {
      if (row.region != n.camera && row.region != n.camera + " " + n.direction) continue;
      if (!(std::pow(n.gray_predicted_dn, 2) > kNoisy * kRoundingVariance)) continue;
      const double least = 1.0 - std::max(kCoverage * n.gray_ratio_sigma, kLeastExcess);
      if (n.sensor_known && n.gray_ratio < least && (!refuting || n.gray_ratio < refuting->gray_ratio))
        refuting = &n;
    }
    if (!refuting) continue;
    row.too_wide_factor = 1.0 / refuting->gray_ratio;
    row.worsen(
        kTooWide,
        fmt::format("the twin states {:.3g} times the noise that the images have ({:.3g} DN, not {:.3g})",
                    row.too_wide_factor, refuting->gray_measured_dn, refuting->gray_predicted_dn));
  }
}

}  // namespace fringetwin::compare
