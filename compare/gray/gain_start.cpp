// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gain_start.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr std::size_t kMostSwept = 20'000, kFewestSwept = 50;
constexpr double kMostNoise = 0.25;       // of a pixel's variance: more of it is not taken for noise
constexpr double kWeakAmplitude = 0.1;    // of the median: shadow
constexpr double kSmallestSweep = 1e-6;   // of the irradiance: constant but for rounding
constexpr double kOutlierSpreads = 10.0;  // a pixel far from the others
constexpr double kOutlierRatio = 0.2;     // and far enough to matter

/// What one pixel sweeps over the images.
struct Sweep {
  double mean_dn = 0.0, mean_e = 0.0;
  double sigma_dn = 0.0, sigma_e = 0.0;  ///< standard deviations over the images
  double ratio() const { return sigma_dn / sigma_e; }
};

/// Returns nothing where a value is clipped.
std::optional<Sweep> sweep_of(const GrayPair& pair, const UsableRange& u, const GrayNoise* noise,
                              std::size_t i) {
  double y1 = 0.0, y2 = 0.0, e1 = 0.0, e2 = 0.0;
  // about the first values: no digits are lost where the sweep is small
  const double y0 = pair.real_at(pair.gain_images.front(), i),
               e0 = pair.irradiance_at(pair.gain_images.front(), i);
  for (const int image : pair.gain_images) {
    const double y = pair.real_at(image, i), v = pair.source_at(image, i);
    if (!(y < u.saturation_dn && v > u.sim_low && v < u.sim_high && std::isfinite(v))) return std::nullopt;
    const double dy = y - y0, de = pair.irradiance_at(image, i) - e0;
    y1 += dy, y2 += dy * dy, e1 += de, e2 += de * de;
  }
  const auto k = static_cast<double>(pair.gain_images.size());
  Sweep s{.mean_dn = y0 + y1 / k, .mean_e = e0 + e1 / k};
  double variance = std::max(0.0, (y2 - y1 * y1 / k) / k);
  // the sensor model speaks of gray values, not of irradiance
  if (noise && (noise->measured() || !pair.real->radiance))
    variance -= std::min(noise->variance(s.mean_dn) * (k - 1.0) / k, kMostNoise * variance);
  s.sigma_dn = std::sqrt(variance);
  s.sigma_e = std::sqrt(std::max(0.0, (e2 - e1 * e1 / k) / k));
  return s;
}

/// Returns the sweeps of pixels that the twin lights.
std::vector<Sweep> sweeps_of(const GrayPair& pair, const GrayNoise* noise) {
  const UsableRange u = usable_range(pair, 1.0, 0.0, {});
  const std::vector<std::size_t> pixels = set_pixels(pair.mask);
  // an odd stride shares no factor with image widths
  const std::size_t stride = pixels.size() / kMostSwept + (pixels.size() / kMostSwept) % 2 + 1;
  std::vector<Sweep> sweeps;
  std::vector<double> sigma_e;
  for (std::size_t at = 0; at < pixels.size(); at += stride)
    if (const auto s = sweep_of(pair, u, noise, pixels[at])) {
      sweeps.push_back(*s);
      sigma_e.push_back(s->sigma_e);
    }
  if (sweeps.empty()) return sweeps;
  const double weak = kWeakAmplitude * upper_median(sigma_e);
  std::erase_if(sweeps, [&](const Sweep& s) {
    return !(s.sigma_e > weak) || !(s.sigma_e > kSmallestSweep * std::abs(s.mean_e));
  });
  return sweeps;
}

}  // namespace

std::optional<GainStart> start_of_amplitudes(const GrayPair& pair, const GrayNoise* noise) {
  if (pair.gain_images.size() < 3) return std::nullopt;
  const std::vector<Sweep> sweeps = sweeps_of(pair, noise);
  if (sweeps.size() < kFewestSwept) return std::nullopt;
  std::vector<double> numbers;
  for (const Sweep& s : sweeps) numbers.push_back(s.ratio());
  GainStart start{.gain_dn = upper_median(numbers), .n_pixels = sweeps.size()};
  if (!(start.gain_dn > 0.0)) return std::nullopt;
  const auto deviation = [&](const Sweep& s) { return s.ratio() / start.gain_dn - 1.0; };
  for (std::size_t k = 0; k < sweeps.size(); ++k) numbers[k] = deviation(sweeps[k]);
  start.spread = mad_sigma(numbers);
  const double far = std::max(kOutlierSpreads * start.spread, kOutlierRatio);
  const auto outliers =
      std::ranges::count_if(sweeps, [&](const Sweep& s) { return std::abs(deviation(s)) > far; });
  start.outlier_share = static_cast<double>(outliers) / static_cast<double>(sweeps.size());
  for (std::size_t k = 0; k < sweeps.size(); ++k)
    numbers[k] = sweeps[k].mean_dn - sweeps[k].ratio() * sweeps[k].mean_e;
  start.black_level_dn = upper_median(numbers);
  return start;
}

}  // namespace fringetwin::compare
