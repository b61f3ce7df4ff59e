// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gray_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "compare/gray/noise_check.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {

using measure::CameraDecode;
using measure::DirectionDecode;

GrayNoise::GrayNoise(const GrayPair& pair, const CameraDecode* real, const std::vector<int>& use_steps)
    : sensor_(pair.camera->sensor), radiance_(pair.real->radiance) {
  int steps_total = 0;
  for (const PatternSpec& p : pair.patterns) steps_total = std::max(steps_total, p.step + 1);
  std::vector<int> steps = use_steps;
  if (steps.empty()) {
    steps.resize(static_cast<std::size_t>(steps_total));
    std::iota(steps.begin(), steps.end(), 0);
  }
  if (real && steps.size() > 3) estimate(pair, *real, steps, steps_total);
  if (measured_)
    source_ = fmt::format("redundancy of the {} phase steps of the real images", steps.size());
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

/// Takes the noise from the first direction that has enough pixels: it is one sensor.
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
        const auto at = std::find(steps.begin(), steps.end(), spec.step);
        if (!spec.is_gray() && spec.direction == static_cast<int>(k) && spec.pitch == static_cast<int>(p) &&
            at != steps.end())
          pitches[p].steps[at - steps.begin()] = &pair.real->images[i];
      }
    }
    measure::NoiseModel model = measure::NoiseModel::linear(0.0, 0.0, 1.0);
    if (pitches.empty() || !measure::estimate_noise(pitches, solver, d.axis, 0.0, model)) continue;
    if (!radiance_) model.raise_to(kRoundingVariance);
    measured_ = model;
  }
}

}  // namespace fringetwin::compare
