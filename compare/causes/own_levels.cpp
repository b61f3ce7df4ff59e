// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/own_levels.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kLeastFactor = 0.01;       ///< below, a pixel sees next to none of the light
constexpr double kLeastDeterminant = 1e-6;  ///< of a determinant: factor and offset do the same

struct LevelLine {
  double factor = 1.0, offset = 0.0;
};

/// Sums over the values of a pixel: e, its irradiance; x, what its offset lets in; r, its real light.
struct LineSums {
  double ee = 0.0, ex = 0.0, xx = 0.0, re = 0.0, rx = 0.0;

  void add(double e, double x, double r) {
    ee += e * e, ex += e * x, xx += x * x;
    re += r * e, rx += r * x;
  }
  /// Returns the line of least squares; where it tells no factor, 1 and the offset that is left.
  LevelLine line(FreePerPixel free) const {
    LevelLine line;
    if (free == FreePerPixel::factor && re > kLeastFactor * ee) line.factor = re / ee;
    if (free == FreePerPixel::factor_and_offset)
      if (const double det = ee * xx - ex * ex, of_factor = re * xx - rx * ex;
          det > kLeastDeterminant * ee * xx && of_factor > kLeastFactor * det)
        line.factor = of_factor / det;
    if (frees_offset(free) && xx > 0.0) line.offset = (rx - line.factor * ex) / xx;
    return line;
  }
};

}  // namespace

OwnLevels::OwnLevels(const GridSamples& s, const std::vector<float>& irradiance,
                     const std::vector<float>& real, FreePerPixel free,
                     const std::vector<double>& exposures) {
  if (free == FreePerPixel::nothing && s.light.empty()) return;
  const std::size_t n = s.images.size();
  factor_.resize(irradiance.size()), offset_.resize(irradiance.size());
  const auto exposure = [&](std::size_t k) { return exposures.empty() ? 1.0 : exposures[k]; };
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < s.n_pixels(); ++p) {
    LineSums sums;
    for (std::size_t k = 0; free != FreePerPixel::nothing && k < n; ++k)
      if (const std::size_t i = p * n + k; s.weight[i] > 0.0F && s.light_of(k) > 0.0)
        sums.add(static_cast<double>(irradiance[i]), exposure(k),
                 static_cast<double>(real[i]) / s.light_of(k));
    const LevelLine own = free == FreePerPixel::nothing ? LevelLine{} : sums.line(free);
    for (std::size_t k = 0; k < n; ++k) {
      const double light = s.light_of(k) > 0.0 ? s.light_of(k) : 1.0;
      factor_[p * n + k] = static_cast<float>(light * own.factor);
      offset_[p * n + k] = static_cast<float>(light * own.offset * exposure(k));
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
