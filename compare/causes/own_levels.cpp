// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/own_levels.hpp"

#include "compare/gray/own_light.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kLeastFactor = 0.01;  ///< below, a pixel sees next to none of the light

/// Returns the line of a pixel, as its texture is told (OwnLightSums); where it tells no factor, 1 and the
/// offset that is left.
OwnLight line_of_levels(const OwnLightSums& sums, const OwnKinds& kinds) {
  const OwnLight line = sums.line(kinds);
  return line.factor > kLeastFactor ? line : sums.line({.factor = false, .offset = kinds.offset});
}

}  // namespace

OwnLevels::OwnLevels(const GridSamples& s, const std::vector<float>& irradiance,
                     const std::vector<float>& real, FreePerPixel free,
                     const std::vector<double>& exposures) {
  const OwnKinds kinds{.factor = frees_factor(free), .offset = frees_offset(free)};
  if (!kinds.any() && s.light.empty()) return;
  const std::size_t n = s.images.size();
  factor_.resize(irradiance.size()), offset_.resize(irradiance.size());
  const auto exposure = [&](std::size_t k) { return exposures.empty() ? 1.0 : exposures[k]; };
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < s.n_pixels(); ++p) {
    OwnLightSums sums;
    for (std::size_t k = 0; kinds.any() && k < n; ++k)
      if (const std::size_t i = p * n + k; s.weight[i] > 0.0F && s.light_of(k) > 0.0)
        sums.add(static_cast<double>(irradiance[i]) / exposure(k),
                 static_cast<double>(real[i]) / (s.light_of(k) * exposure(k)));
    const OwnLight own = line_of_levels(sums, kinds);
    for (std::size_t k = 0; k < n; ++k) {
      const double light = s.light_of(k) > 0.0 ? s.light_of(k) : 1.0;
      factor_[p * n + k] = static_cast<float>(light * own.factor);
      offset_[p * n + k] = static_cast<float>(light * own.offset_dn * exposure(k));
    }
  }
}

void OwnLevels::to_levels(std::vector<float>& values) const {
  for (std::size_t i = 0; i < factor_.size(); ++i) values[i] = factor_[i] * values[i] + offset_[i];
}

void OwnLevels::to_irradiance(std::vector<float>& values) const {
  for (std::size_t i = 0; i < factor_.size(); ++i) values[i] = (values[i] - offset_[i]) / factor_[i];
}

std::vector<float> real_light(const GridSamples& s) {
  std::vector<float> light(s.real_dn.size());
  for (std::size_t i = 0; i < light.size(); ++i)
    light[i] = static_cast<float>((static_cast<double>(s.real_dn[i]) - s.black_level_dn) / s.gain_dn);
  return light;
}

}  // namespace fringetwin::compare
