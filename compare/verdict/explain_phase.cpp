// SPDX-License-Identifier: Apache-2.0
// Judges the phase difference and its ripples.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/phase/phase_rows.hpp"
#include "compare/phase/texture_shift.hpp"
#include "compare/verdict/block_sums.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;

/// Times the rounding's variance: noise that smooths the ripple that rounding alone leaves to 1e-4 of it.
constexpr double kSmoothRounding = 4.0;
/// Standard deviations of chi2 over its degrees of freedom: its tail is longer than a normal one (12: 3e-4).
constexpr double kRippleCoverage = 5.0;
/// Of the regional chi2 beyond noise: fringes that lie elsewhere from place to place, as those of an object
/// that was moved, look like ripples by as much (0.5 % for a ball moved by 0.1 mm).
constexpr double kRippleOfShifts = 0.01;
/// Returns how well the noise of this side's phases is known: relative, of its variance. `is_drawn`: the side
/// is simulated, and its noise was drawn from what the twin states.
double noise_known_to(const DirectionDecode& side, bool is_drawn) {
  if (side.noise_source == measure::NoiseSource::residuals)
    return std::hypot(kMeasuredKnownTo, side.noise_known_to);
  return is_drawn && side.noise_source == measure::NoiseSource::known ? 0.0 : kStatedKnownTo;
}

}  // namespace

ExplainedRow explain_phase(const std::string& camera, const DirectionDecode& real,
                           const DirectionDecode& simulated, const ImageU8& interior,
                           const TextureShift& texture, const RenderingError& rendering,
                           const RigVariance& rig, const SeenPixels& seen, const ShapeInView& shape) {
  const ImageF difference = phase_difference(real, simulated);
  const double per_px = kTwoPi / real.pitches_px[real.finest];
  const double shared = rendering.phase_rad * rendering.phase_rad;
  double real_noise = 0.0, simulated_noise = 0.0;
  const auto variance = [&](const DirectionDecode& d, std::size_t i) {
    const double s = per_px * static_cast<double>(d.coordinate_sigma_px.data[i]);
    return std::isfinite(s) ? s * s : 0.0;
  };
  ExplainedRow row;
  const Sums s =
      sum_blocks(difference.width, difference.height, row.regions, [&](int x0, int y0, int x1, int y1) {
        Sums out;
        BlockSum mean;
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x) {
            const auto d = static_cast<double>(difference(x, y));
            if (interior(x, y) == 0 || std::isnan(d)) continue;
            const std::size_t i = difference.index(x, y);
            const double noise = variance(real, i) + variance(simulated, i);
            if (!(noise > 0.0)) continue;
            const double moved = rig.variance ? static_cast<double>(rig.variance->data[i]) : 0.0;
            const double textured = std::pow(static_cast<double>(texture.largest_rad.data[i]), 2);
            const double moved_by_shape = per_px * shape.moved_px_at(real.axis, i);
            const double of_shape = moved_by_shape * moved_by_shape;
            const double own = noise + textured;
            const SmoothedAt smoothed_px = shape.smoothed_px_at(real.axis, i);
            const double smoothed = std::pow(per_px * smoothed_px.size, 2);
            out.texture += textured;
            out.shape += of_shape;
            out.smoothed += smoothed;
            mean.smoothed_depths += per_px * smoothed_px.value;  // the difference is simulated - real
            if (of_shape > 0.0) mean.depths += moved_by_shape * std::sqrt(shape.shares_at(i).depth);
            out.add(d * d, noise, own + of_shape + smoothed, shared, moved);
            mean.add(1.0, d, own, moved);
            mean.together += static_cast<double>(texture.signed_rad.data[i]);
            ++mean.pixels;
          }
        add_region(mean, shared, out);
        return out;
      });
  row.quantity = "phase";
  row.region = camera + " " + axis_name(real.axis);
  row.unit = "rad";
  row.states_noise = real.noise_source == measure::NoiseSource::known;
  std::uint64_t agree = 0;
  for (const float d : difference.data) agree += std::isnan(d) ? 0 : 1;
  if (!take_sums(s, row)) {
    row.worsen(kNotCompared, real.unwrapped && simulated.unwrapped
                                 ? too_few(s.n, seen, agree)
                                 : "the phases are not unwrapped, so they have no fringe order");
    return row;
  }
  for (std::size_t i = 0; i < difference.size(); ++i)
    if (interior.data[i] != 0 && !std::isnan(difference.data[i])) {
      real_noise += variance(real, i);
      simulated_noise += variance(simulated, i);
    }
  const auto n = static_cast<double>(s.n);
  row.lines = {{"noise and quantisation of the real images", real_noise / n},
               {"noise and quantisation of the simulated images", simulated_noise / n},
               rendering.line(shared)};
  if (s.texture > 0.0) row.lines.push_back({"texture within a pixel", s.texture / n});
  if (shape.noise) row.lines.push_back({kShapeLine, s.shape / n});
  if (s.smoothed > 0.0) row.lines.push_back({kSmoothedLine, s.smoothed / n});
  if (rig.variance) row.lines.push_back({rig.line, s.calibration / n});
  const double known_to = std::hypot(real_noise * noise_known_to(real, false),
                                     simulated_noise * noise_known_to(simulated, true)) /
                          (real_noise + simulated_noise);
  judge(s, known_to, 1.0, row);
  judge_least(s, std::min(real.noise_dn * real.noise_dn, simulated.noise_dn * simulated.noise_dn),
              kRoundingVariance, 1.0, known_to, row);
  // the simulated side has the noise that is stated: only the real one's can be too small
  if (row.noise_chi2 < row.chi2_least) {
    const double seen_noise = row.noise_chi2 * (real_noise + simulated_noise) - simulated_noise;
    if (seen_noise > kLeastExcess * real_noise) row.too_wide_factor = std::sqrt(real_noise / seen_noise);
  }
  if (seen.either > 0) judge_share(share_of(agree, seen.either), kOfPixels, row);
  return row;
}

void judge_ripple(const RippleTest& ripple, const RenderingError& rendering, const DirectionDecode& real,
                  const DirectionDecode& simulated, ExplainedRow& row) {
  if (!std::isfinite(row.chi2) || row.lines.back().name == kCalibrationLine) return;
  const double noise_dn = std::min(real.noise_dn, simulated.noise_dn);
  if (!(noise_dn * noise_dn > kSmoothRounding * kRoundingVariance)) return;
  const auto p = static_cast<double>(ripple.functions);
  row.brightness_chi2 = ripple.brightness_chi2;
  row.harmonic_chi2 = ripple.harmonic_chi2;
  const double beyond_noise = row.n_regions > 0 ? std::max(0.0, row.regional_chi2_of_noise - 1.0) : 0.0;
  row.ripple_limit = 1.0 + kRippleCoverage * std::sqrt(2.0 / p) +
                     rendering.phase_rad * rendering.phase_rad * ripple.information / p +
                     kRippleOfShifts * beyond_noise;
  if (row.brightness_chi2 > row.ripple_limit)
    row.worsen(kNotExplained,
               fmt::format("the phase ripples with the fringes ({:.3g} times what noise does): "
                           "the brightness varies from image to image",
                           row.brightness_chi2));
  if (row.harmonic_chi2 > row.ripple_limit)
    row.worsen(kNotExplained, fmt::format("the phase ripples {} times per fringe ({:.3g} times what noise "
                                          "does): the real fringes are not the waveform of the twin",
                                          ripple.strongest, row.harmonic_chi2));
}

}  // namespace fringetwin::compare
