// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gray_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/photometry/photon_transfer.hpp"
#include "compare/gray/noise_check.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

using measure::CameraDecode;
using measure::DirectionDecode;

namespace {

constexpr std::size_t kMostMeanSamples = 200'000, kMostUnlitSamples = 50'000, kMostKnownPixels = 20'000;

/// Returns the values of about `most` samples, or all, of the pixels that are set in `among`.
std::vector<measure::NoiseValue> values_of_means(const std::vector<std::vector<const GrayImage*>>& images,
                                                 const measure::StepSolver& solver, Axis axis,
                                                 const GrayPair& pair, const ImageU8& among,
                                                 std::size_t most) {
  std::vector<calib::NoiseSample> samples;
  calib::add_mean_noise(images, solver, axis, pair.real->saturation_dn(), most, samples, &among);
  std::vector<measure::NoiseValue> values;
  for (const calib::NoiseSample& s : samples) values.push_back({s.level_dn, s.noise_dn, s.roughness_dn});
  return values;
}

/// Returns the noise of three steps from the means of several pitches.
std::optional<measure::NoiseModel> noise_of_means(const std::vector<measure::NoiseInput>& pitches,
                                                  const measure::StepSolver& solver, Axis axis,
                                                  const GrayPair& pair, const ImageU8& flags) {
  std::vector<std::vector<const GrayImage*>> images;
  for (const measure::NoiseInput& p : pitches) images.push_back(p.steps);
  ImageU8 lit(flags.width, flags.height, 0), unlit = lit;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    lit.data[i] = (flags.data[i] & measure::kUnseen) == 0 ? 1 : 0;
    unlit.data[i] = (flags.data[i] & measure::kUnseen) == measure::kLowModulation ? 1 : 0;
  }
  const std::size_t together = pitches.size() - 1;
  std::vector<measure::NoiseValue> values =
      values_of_means(images, solver, axis, pair, lit, kMostMeanSamples);
  const double darkest = measure::add_unlit(
      values_of_means(images, solver, axis, pair, unlit, std::min(values.size(), kMostUnlitSamples)),
      together, {.saturation = pair.real->saturation_dn(), .least = kRoundingVariance}, values);
  return measure::fit_noise(values, together, std::max(darkest, pair.camera->sensor.black_level_dn),
                            kRoundingVariance);
}

/// Returns the mean real gray value of pixels that both sides measure.
std::vector<float> mean_levels(const GrayPair& pair) {
  std::vector<float> levels;
  for (const std::size_t i : set_pixels(pair.mask, kMostKnownPixels)) {
    double sum = 0.0;
    for (const int image : pair.gain_images) sum += pair.real_at(image, i);
    levels.push_back(static_cast<float>(sum / static_cast<double>(pair.gain_images.size())));
  }
  return levels;
}

}  // namespace

GrayNoise::GrayNoise(const GrayPair& pair, const CameraDecode* real, const std::vector<int>& use_steps)
    : sensor_(pair.camera->sensor), radiance_(pair.real->radiance) {
  int steps_total = 0;
  for (const PatternSpec& p : pair.patterns) steps_total = std::max(steps_total, p.step + 1);
  const std::vector<int> steps = use_steps.empty() ? measure::all_steps(steps_total) : use_steps;
  if (real && steps.size() >= 3) estimate(pair, *real, steps, steps_total);
  if (measured_) {
    take_dark(pair);
    known_to_ = known_to(mean_levels(pair));
    source_ = steps.size() > 3
                  ? fmt::format("redundancy of the {} phase steps of the real images", steps.size())
                  : "differences between the pitches' means of the real images";
    if (dark_) source_ += ", dark pixels of their code";
  } else if (sensor_.has_noise())
    source_ = "sensor model of the twin, not measured on these images";
  else
    source_ = "quantisation only";
  // quantisation of the simulated images comes on top
  if (pair.from_dn) added_ = kRoundingVariance;
}

double GrayNoise::rounding_dn2() const { return (radiance_ ? 0.0 : kRoundingVariance) + added_; }

double GrayNoise::known_to(const std::vector<float>& levels) const {
  if (!measured_) return kStatedKnownTo;
  return std::hypot(kMeasuredKnownTo, measured_->known_to(levels));
}

double GrayNoise::variance(double gray_dn) const {
  if (measured_) {
    const double line_dn2 = measured_->variance(gray_dn);
    return (dark_ && gray_dn < measured_->level ? std::max(line_dn2, dark_->variance_dn2) : line_dn2) +
           added_;
  }
  const CameraResponse& response = sensor_.response;
  if (response.straight())
    return sensor_variance_dn2(sensor_, gray_dn) - (radiance_ ? kRoundingVariance : 0.0) + added_;
  // The pair's values are straightened: noise of the values as they were taken is divided by the slope.
  const double light = gray_dn - sensor_.black_level_dn;
  return (sensor_variance_dn2(sensor_, response(light) + sensor_.black_level_dn) -
          (radiance_ ? kRoundingVariance : 0.0) + added_) /
         std::pow(response.slope(light), 2);
}

void GrayNoise::take_dark(const GrayPair& pair) {
  constexpr double kSigmas = 4.0;  // further apart, the noise is no line of the level down to there
  const auto dark = dark_noise(pair);
  measure::NoiseModel& line = *measured_;
  if (!dark || !(dark->level_dn < line.level)) return;
  dark_ = dark;
  // Least squares of height and slope, which are independent at line.level, and of one more value there is
  const double height_dn2 = line.offset + line.per_unit * line.level, h2 = std::pow(line.height_sigma, 2),
               b2 = std::pow(line.slope_sigma, 2), away_dn = dark->level_dn - line.level,
               all2 = h2 + away_dn * away_dn * b2 + std::pow(dark->sigma_dn2, 2),
               more_dn2 = dark->variance_dn2 - height_dn2 - line.per_unit * away_dn,
               limit2 = kSigmas * kSigmas * (all2 + std::pow(kMeasuredKnownTo * height_dn2, 2));
  if (!(b2 > 0.0) || more_dn2 * more_dn2 > limit2) return;
  const double height = height_dn2 + h2 / all2 * more_dn2,
               slope = std::max(0.0, line.per_unit + away_dn * b2 / all2 * more_dn2);
  const double hh = h2 - h2 * h2 / all2, bb = b2 - away_dn * away_dn * b2 * b2 / all2,
               hb = -h2 * away_dn * b2 / all2;
  line.per_unit = slope;
  line.offset = height - slope * line.level;
  line.level -= hb / bb;  // where both are independent again
  line.height_sigma = std::sqrt(std::max(0.0, hh - hb * hb / bb));
  line.slope_sigma = std::sqrt(bb);
}

void GrayNoise::estimate(const GrayPair& pair, const CameraDecode& real, const std::vector<int>& steps,
                         int steps_total) {
  const measure::StepSolver solver(steps, steps_total);
  for (std::size_t k = 0; k < real.directions.size() && !measured_; ++k) {
    const DirectionDecode& d = real.directions[k];
    std::vector<measure::NoiseInput> pitches(d.wrapped_rad.size());
    for (std::size_t p = 0; p < pitches.size(); ++p) {
      pitches[p] = {std::vector<const GrayImage*>(steps.size(), nullptr), &d.wrapped_rad[p],
                    &d.amplitude_dn[p]};
      for (std::size_t i = 0; i < pair.patterns.size(); ++i) {
        const PatternSpec& spec = pair.patterns[i];
        const auto at = std::ranges::find(steps, spec.step);
        if (!spec.is_gray() && spec.direction == static_cast<int>(k) && spec.pitch == static_cast<int>(p) &&
            at != steps.end())
          pitches[p].steps[at - steps.begin()] = &pair.real->images[i];
      }
    }
    if (pitches.empty()) continue;
    if (steps.size() == 3) {
      if (pitches.size() > 1 && !radiance_)
        measured_ = noise_of_means(pitches, solver, d.axis, pair, real.flags);
    } else {
      measured_ = measure::estimate_noise(
          pitches, solver, d.axis,
          {.saturation = pair.real->saturation_dn(), .least = radiance_ ? 0.0 : kRoundingVariance});
    }
  }
}

}  // namespace fringetwin::compare
