// SPDX-License-Identifier: Apache-2.0
#include "compare/pattern/what_is_left.hpp"

#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "compare/causes/cause_fit.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kNoFringes = 1e-4;  ///< of the mean irradiance: a smaller amplitude has no phase

/// Fills the phases of a pixel's values: E = m + A cos(phase of the place + step), steps spread evenly.
void add_phases(const std::map<std::pair<int, int>, std::vector<StepImage>>& pitches, const float* irradiance,
                std::vector<LeftValue>& pixel) {
  for (const auto& [pitch, images] : pitches) {
    if (images.size() < 3) continue;
    double mean = 0.0, cosine = 0.0, sine = 0.0;
    for (const auto& [at, step_rad] : images) {
      const auto e = static_cast<double>(irradiance[at]);
      mean += e;
      cosine += 2.0 * e * std::cos(step_rad);
      sine -= 2.0 * e * std::sin(step_rad);
    }
    if (!(std::hypot(cosine, sine) > kNoFringes * mean)) continue;
    const double phase_rad = std::atan2(sine, cosine);
    for (const auto& [at, step_rad] : images) pixel[at].phase_rad = static_cast<float>(phase_rad + step_rad);
  }
}

/// Takes out what numbers of the pixel's own explain: of its values, and of the light that a factor is of.
void take_own_out(const GridSamples& s, const float* irradiance, std::size_t first, FreePerPixel own,
                  std::vector<LeftValue>& pixel) {
  std::vector<double> light, weight;
  for (std::size_t k = 0; k < pixel.size(); ++k) {
    light.push_back(s.light_of(k) * static_cast<double>(s.weight[first + k] * irradiance[k]));
    weight.push_back(static_cast<double>(s.weight[first + k]));
  }
  const auto product = [](const auto& a, const auto& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const auto take_out = [&](const std::vector<double>& direction) {
    double along = 0.0;
    for (std::size_t k = 0; k < pixel.size(); ++k)
      along += direction[k] * static_cast<double>(pixel[k].sigmas);
    const double size = product(direction, direction);
    for (std::size_t k = 0; size > 0.0 && k < pixel.size(); ++k)
      pixel[k].sigmas -= static_cast<float>(direction[k] * along / size);
  };
  if (frees_offset(own)) {
    take_out(weight);
    const double size = product(weight, weight), along = size > 0.0 ? product(weight, light) / size : 0.0;
    for (std::size_t k = 0; k < light.size(); ++k) light[k] -= along * weight[k];
  }
  if (frees_factor(own)) take_out(light);
}

/// Returns what is left of a pixel's values; `irradiance`: what is predicted of them, `first`: place of the
/// first one.
std::vector<LeftValue> values_of_pixel(const GridSamples& s, const std::vector<float>& irradiance,
                                       std::size_t first, std::size_t width) {
  const std::size_t cell = s.cell[first / s.images.size()], across = static_cast<std::size_t>(s.grid.width),
                    at = s.grid.pixel_of(static_cast<int>(cell % across), static_cast<int>(cell / across),
                                         static_cast<int>(width));
  std::vector<LeftValue> pixel;
  for (std::size_t i = first; i < first + s.images.size(); ++i)
    pixel.push_back({.sigmas = s.weight[i] * static_cast<float>(Sensitivity::residual(s, irradiance, i)),
                     .level_dn = static_cast<float>(
                         s.gain_of(i - first) * static_cast<double>(irradiance[i]) + s.black_level_dn),
                     .phase_rad = NAN,
                     .x_px = static_cast<float>(at % width),
                     .y_px = static_cast<float>(at / width),
                     .image = s.images[i - first]});
  return pixel;
}

}  // namespace

LeftOver what_is_left(const GridSamples& s, const std::vector<float>& irradiance, const Twin& twin,
                      double scale, FreePerPixel own) {
  const Camera& camera = twin.cameras[s.camera];
  const int width = camera.lens.width(), height = camera.lens.height();
  LeftOver left{camera.name, 0.5 * (width - 1), 0.5 * (height - 1), {}};
  const auto pitches = steps_of_pitches(s, twin.fringes);
  const auto most = static_cast<float>(scale);
  for (std::size_t first = 0; first < s.real_dn.size(); first += s.images.size()) {
    std::vector<LeftValue> pixel = values_of_pixel(s, irradiance, first, static_cast<std::size_t>(width));
    add_phases(pitches, irradiance.data() + first, pixel);
    if (own != FreePerPixel::nothing) take_own_out(s, irradiance.data() + first, first, own, pixel);
    for (std::size_t k = 0; k < pixel.size(); ++k) {
      if (!(s.weight[first + k] > 0.0F)) continue;
      if (const float size = std::abs(pixel[k].sigmas); size > most)
        pixel[k].sigmas *= std::sqrt(most / size);
      left.values.push_back(pixel[k]);
    }
  }
  return left;
}

std::vector<PatternRow> pattern_of_rest(const Sensitivity& sensitivity, const Twin& twin) {
  const Sensitivity::Values predicted = sensitivity.irradiance(twin, sensitivity.residual_samples());
  const CauseFit as_it_is = fit_cause(sensitivity, twin, {}, FreePerPixel::nothing, {.predicted = predicted});
  const auto n = static_cast<double>(as_it_is.n);
  double excess = as_it_is.chi2 > sensitivity.chi2_limit(n) ? n * (as_it_is.chi2 - 1.0) : 0.0;
  if (excess == 0.0)
    for (const CauseRegion& kind : as_it_is.regions)
      if (!kind.passes()) excess += static_cast<double>(kind.n) * (kind.chi2 - 1.0);
  const std::vector<GridSamples>& samples = as_it_is.sensors.samples();
  std::vector<LeftOver> left;
  for (std::size_t c = 0; c < samples.size(); ++c)
    left.push_back(what_is_left(samples[c], predicted[c], twin, sensitivity.scale()[c],
                                sensitivity.with_own(FreePerPixel::nothing)));
  return find_pattern(left, excess);
}

}  // namespace fringetwin::compare
