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

constexpr std::size_t kMostMeanSamples = 1'000'000, kMostLevels = 24, kFewestAtLevel = 400;

/// Returns the variance over the level, from levels that hold as many samples each; nothing with too few.
std::optional<measure::NoiseModel> noise_over_level(std::vector<calib::NoiseSample> samples) {
  const std::size_t n = samples.size(), levels = std::min(kMostLevels, n / kFewestAtLevel);
  std::ranges::sort(samples, [](const auto& a, const auto& b) { return a.level_dn < b.level_dn; });
  std::vector<double> mean, variance;
  for (std::size_t k = 0; k < levels; ++k) {
    const std::vector<calib::NoiseSample> some(
        samples.begin() + static_cast<std::ptrdiff_t>(n * k / levels),
        samples.begin() + static_cast<std::ptrdiff_t>(n * (k + 1) / levels));
    double level = 0.0;
    for (const calib::NoiseSample& s : some) level += static_cast<double>(s.level_dn);
    level /= static_cast<double>(some.size());
    const double v = calib::noise_variance(some).value;
    if (!std::isfinite(v) || (!mean.empty() && !(level > mean.back()))) continue;
    mean.push_back(level);
    variance.push_back(v);
  }
  if (mean.empty()) return std::nullopt;
  return measure::NoiseModel::tabulated(mean, variance);
}

/// Returns the noise of three steps from the means of several pitches.
std::optional<measure::NoiseModel> noise_of_means(const std::vector<measure::NoiseInput>& pitches,
                                                  const measure::StepSolver& solver, Axis axis,
                                                  double saturation_dn, const ImageU8& flags) {
  std::vector<std::vector<const ImageF*>> images;
  for (const measure::NoiseInput& p : pitches) images.push_back(p.steps);
  std::vector<calib::NoiseSample> samples;
  calib::add_mean_noise(images, solver, axis, saturation_dn, kMostMeanSamples, samples);
  std::erase_if(samples,
                [&](const calib::NoiseSample& s) { return (flags(s.x, s.y) & measure::kUnseen) != 0; });
  return noise_over_level(std::move(samples));
}

}  // namespace

GrayNoise::GrayNoise(const GrayPair& pair, const CameraDecode* real, const std::vector<int>& use_steps)
    : sensor_(pair.camera->sensor), radiance_(pair.real->radiance) {
  int steps_total = 0;
  for (const PatternSpec& p : pair.patterns) steps_total = std::max(steps_total, p.step + 1);
  const std::vector<int> steps = use_steps.empty() ? measure::all_steps(steps_total) : use_steps;
  if (real && steps.size() >= 3) estimate(pair, *real, steps, steps_total);
  if (measured_)
    source_ = steps.size() > 3
                  ? fmt::format("redundancy of the {} phase steps of the real images", steps.size())
                  : "differences between the pitches' means of the real images";
  else if (sensor_.has_noise())
    source_ = "sensor model of the twin, not measured on these images";
  else
    source_ = "quantisation only";
  // quantisation of the simulated images comes on top
  if (pair.from_dn) added_ = kRoundingVariance;
}

double GrayNoise::rounding_dn2() const { return (radiance_ ? 0.0 : kRoundingVariance) + added_; }

double GrayNoise::variance(double gray_dn) const {
  if (measured_) return measured_->variance(gray_dn) + added_;
  return sensor_variance_dn2(sensor_, gray_dn) - (radiance_ ? kRoundingVariance : 0.0) + added_;
}

void GrayNoise::estimate(const GrayPair& pair, const CameraDecode& real, const std::vector<int>& steps,
                         int steps_total) {
  const measure::StepSolver solver(steps, steps_total);
  for (std::size_t k = 0; k < real.directions.size() && !measured_; ++k) {
    const DirectionDecode& d = real.directions[k];
    std::vector<measure::NoiseInput> pitches(d.wrapped_rad.size());
    for (std::size_t p = 0; p < pitches.size(); ++p) {
      pitches[p] = {std::vector<const ImageF*>(steps.size(), nullptr), &d.wrapped_rad[p], &d.amplitude_dn[p],
                    &d.mean_dn};
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
        measured_ = noise_of_means(pitches, solver, d.axis, pair.real->saturation_dn(), real.flags);
    } else {
      measure::NoiseModel model = measure::NoiseModel::linear(0.0, 0.0, 1.0);
      if (measure::estimate_noise(pitches, solver, d.axis, 0.0, model)) measured_ = model;
    }
    if (measured_ && !radiance_) measured_->raise_to(kRoundingVariance);
  }
}

}  // namespace fringetwin::compare
