// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/noise_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "calib/photometry/photon_transfer.hpp"
#include "measure/decode/decode_input.hpp"
#include "measure/decode/phase.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"
#include "twin/image/rows_of_images.hpp"

namespace fringetwin::compare {
namespace {

using calib::NoiseSample;

constexpr double kRough = 4.0;  // texture: more than this many sigmas of what white noise does
constexpr std::size_t kMaxSamples = 2'000'000;
constexpr std::size_t kFewestOfLevel = 400;
constexpr std::size_t kFewestInLevel = 200, kFewestInCell = 50;
constexpr int kLevels = 32;
constexpr int kFewestGroups = 12;  // too few blocks of the image say nothing about correlation

/// A robust standard deviation of values that should have 1.
struct Spread {
  double value = kNaN, sigma = kNaN, cut = 0.0;
  std::uint64_t n = 0;
  bool keeps(const NoiseSample& s) const {
    return std::abs(static_cast<double>(s.noise_dn)) <= cut &&
           static_cast<double>(s.roughness_dn) <= kRough * value;
  }
};

/// Computes the spread. Its standard error comes from the blocks of the image (errors of one place belong
/// together) and is never below that of independent values.
Spread spread_of(const std::vector<NoiseSample>& z) {
  Spread out;
  if (z.size() < kFewestOfLevel) return out;
  out.value = std::sqrt(calib::noise_variance(z).value);
  out.cut = calib::kCutSigmas * out.value;
  std::array<double, calib::kBlocks> square{}, n{};
  for (const NoiseSample& s : z) {
    if (!out.keeps(s)) continue;
    square[s.block] += std::pow(static_cast<double>(s.noise_dn), 2) / calib::kKeptVariance;
    n[s.block] += 1.0;
  }
  const double all = std::accumulate(n.begin(), n.end(), 0.0), variance = out.value * out.value;
  out.n = static_cast<std::uint64_t>(all);
  if (out.n < kFewestOfLevel) return {};
  double sum = 0.0;
  int groups = 0;
  for (std::size_t b = 0; b < n.size(); ++b)
    if (n[b] > 0.0) {
      sum += std::pow(square[b] - variance * n[b], 2);
      ++groups;
    }
  const double blocks = groups < kFewestGroups ? 0.0 : std::sqrt(sum * groups / (groups - 1.0)) / all;
  out.sigma = std::max(blocks, variance * std::sqrt(2.0 / all)) / (2.0 * out.value);
  return out;
}

// ---- gray values: what the fit of mean, cosine and sine leaves, or the means of three steps ------------

/// Returns the samples where the camera sees fringes. Whether their order was found does not matter: noise
/// that the decode was told far too large refuses every order.
std::vector<NoiseSample> residuals(const std::vector<std::vector<const GrayImage*>>& pitches, Axis axis,
                                   const CameraImages& real, const ImageU8& flags) {
  const auto steps = static_cast<int>(pitches.front().size());
  const measure::StepSolver solver(measure::all_steps(steps), steps);
  std::vector<NoiseSample> samples;
  if (steps > 3)
    for (const auto& images : pitches)
      calib::add_step_noise(images, solver, axis, real.saturation_dn(), kMaxSamples / pitches.size(),
                            samples);
  else
    calib::add_mean_noise(pitches, solver, axis, real.saturation_dn(), kMaxSamples, samples);
  std::erase_if(samples, [&](const NoiseSample& s) { return (flags(s.x, s.y) & measure::kUnseen) != 0; });
  return samples;
}

/// Residuals in units of the predicted sigma.
std::vector<NoiseSample> normalised(std::vector<NoiseSample> samples, const Sensor& sensor) {
  for (NoiseSample& s : samples) {
    const auto sigma =
        static_cast<float>(std::sqrt(sensor_variance_dn2(sensor, static_cast<double>(s.level_dn))));
    s.noise_dn /= sigma;
    s.roughness_dn /= sigma;
  }
  return samples;
}

std::vector<NoiseLevel> by_level(const std::vector<NoiseSample>& samples, const std::vector<NoiseSample>& z,
                                 const Spread& spread, const Sensor& sensor) {
  const auto [low, high] =
      std::minmax_element(samples.begin(), samples.end(),
                          [](const NoiseSample& a, const NoiseSample& b) { return a.level_dn < b.level_dn; });
  const double first = static_cast<double>(low->level_dn);
  const double per_dn = kLevels / std::max(1e-9, static_cast<double>(high->level_dn) - first);
  struct Sums {
    double level = 0, square = 0;
    std::uint64_t n = 0;
  };
  std::array<Sums, kLevels> sums;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!spread.keeps(z[i])) continue;
    const double level = static_cast<double>(samples[i].level_dn);
    Sums& s = sums[static_cast<std::size_t>(std::min(kLevels - 1.0, (level - first) * per_dn))];
    s.level += level;
    s.square += std::pow(static_cast<double>(samples[i].noise_dn), 2);
    ++s.n;
  }
  std::vector<NoiseLevel> out;
  for (const Sums& s : sums) {
    if (s.n < kFewestInLevel) continue;
    const double n = static_cast<double>(s.n), level = s.level / n;
    out.push_back({level, std::sqrt(s.square / n / calib::kKeptVariance),
                   std::sqrt(sensor_variance_dn2(sensor, level)), s.n});
  }
  return out;
}

ImageF block_map(const std::vector<NoiseSample>& z, const Spread& spread, int width, int height) {
  ImageF map((width + kNoiseBlock - 1) / kNoiseBlock, (height + kNoiseBlock - 1) / kNoiseBlock, 0.0f);
  std::vector<std::size_t> n(map.size());
  for (const NoiseSample& s : z) {
    if (!spread.keeps(s)) continue;
    const std::size_t i = map.index(s.x / kNoiseBlock, s.y / kNoiseBlock);
    map.data[i] += s.noise_dn * s.noise_dn;
    ++n[i];
  }
  for (std::size_t i = 0; i < map.size(); ++i)
    map.data[i] =
        n[i] < kFewestInCell
            ? std::numeric_limits<float>::quiet_NaN()
            : std::sqrt(map.data[i] / static_cast<float>(static_cast<double>(n[i]) * calib::kKeptVariance));
  return map;
}

/// Fills the quantiles at whole tenths of a normal sigma, as far out as five values reach.
void put_quantiles(const std::vector<NoiseSample>& z, const Spread& spread, NoiseRow& row) {
  std::vector<float> values;
  for (const NoiseSample& s : z)
    if (static_cast<double>(s.roughness_dn) <= kRough * spread.value) values.push_back(s.noise_dn);
  std::ranges::sort(values);
  for (int k = -45; k <= 45; ++k) {
    const double q = 0.1 * k, below = 0.5 * std::erfc(-q / std::numbers::sqrt2);
    const double at = below * static_cast<double>(values.size());
    if (std::min(at, static_cast<double>(values.size()) - at) < 5.0) continue;
    row.normal_quantile.push_back(q);
    row.residual_quantile.push_back(static_cast<double>(values[static_cast<std::size_t>(at)]));
  }
}

bool check_gray(const Camera& camera, const std::vector<std::vector<const GrayImage*>>& pitches, Axis axis,
                const CameraImages& real, const ImageU8& flags, NoiseRow& row) {
  const std::vector<NoiseSample> samples = residuals(pitches, axis, real, flags);
  const std::vector<NoiseSample> z = normalised(samples, camera.sensor);
  const Spread spread = spread_of(z);
  if (!std::isfinite(spread.value)) return false;
  row.gray_ratio = spread.value;
  row.gray_ratio_sigma = spread.sigma;
  row.n = spread.n;
  double measured = 0.0, predicted = 0.0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!spread.keeps(z[i])) continue;
    measured += std::pow(static_cast<double>(samples[i].noise_dn), 2) / calib::kKeptVariance;
    predicted += sensor_variance_dn2(camera.sensor, static_cast<double>(samples[i].level_dn));
  }
  row.gray_measured_dn = std::sqrt(measured / static_cast<double>(spread.n));
  row.gray_predicted_dn = std::sqrt(predicted / static_cast<double>(spread.n));
  row.levels = by_level(samples, z, spread, camera.sensor);
  row.ratio_map = block_map(z, spread, flags.width, flags.height);
  put_quantiles(z, spread, row);
  return true;
}

// ---- phase: what differs from its neighbours along the stripe ------------------------------------------

/// Returns the median of |sigma_i e_i|, e normal: what upper_median() gives of values that scatter as
/// predicted.
double median_of_normals(const std::vector<float>& sigma) {
  double low = 0.0, high = static_cast<double>(*std::ranges::max_element(sigma));
  const std::size_t stride = 1 + sigma.size() / 20'000;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    double below = 0.0, n = 0.0;
    for (std::size_t k = 0; k < sigma.size(); k += stride, n += 1.0)
      below += std::erf(middle / (std::numbers::sqrt2 * static_cast<double>(sigma[k])));
    (below < 0.5 * n ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Returns the variance of the finest phase that the sensor predicts.
ImageF predicted_variance(const Sensor& sensor, const measure::DirectionDecode& d,
                          const measure::StepSolver& solver) {
  const ImageF &phase = d.wrapped_rad[d.finest], &amplitude = d.amplitude_dn[d.finest];
  ImageF out(phase.width, phase.height);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto b = static_cast<double>(amplitude.data[i]), p = static_cast<double>(phase.data[i]);
    out.data[i] = static_cast<float>(sensor_variance_dn2(sensor, static_cast<double>(d.mean_dn.data[i])) /
                                     (b * b) * solver.phase_variance(std::cos(p), std::sin(p)));
  }
  return out;
}

/// Returns the phase that the twin has without noise at each pixel, NaN where it is dark.
ImageF exact_phase(const std::vector<const GrayImage*>& steps, const measure::StepSolver& solver) {
  constexpr float kDark = 1e-3f;  // of the largest amplitude
  ImageF phase(steps.front()->width, steps.front()->height), amplitude = phase;
  std::vector<const float*> rows;
  RowsOfImages of_images;
  for (const GrayImage* step : steps) rows.push_back(of_images.whole(*step));
  measure::solve_row(solver, rows.data(), static_cast<int>(phase.size()),
                     {.phase_rad = phase.data.data(), .amplitude = amplitude.data.data()});
  const float least = kDark * *std::ranges::max_element(amplitude.data);
  for (std::size_t i = 0; i < phase.size(); ++i)
    if (!(amplitude.data[i] > least)) phase.data[i] = std::numeric_limits<float>::quiet_NaN();
  return phase;
}

/// `shape`: the twin's own phase, whose bends are no noise; may be empty.
void check_phase(const Camera& camera, const measure::DirectionDecode& d, const ImageU8& flags,
                 const measure::StepSolver& solver, const ImageF& shape, NoiseRow& row) {
  ImageF phase = d.wrapped_rad[d.finest];
  for (std::size_t i = 0; i < shape.size(); ++i) phase.data[i] -= shape.data[i];
  const ImageF variance = predicted_variance(camera.sensor, d, solver);
  const int dx = d.axis == Axis::x ? 0 : 1, dy = 1 - dx;  // the stripes of column patterns run along camera y
  std::vector<NoiseSample> z;
  std::vector<float> measured, predicted;
  // every second triple: neighbours share a pixel
  for (int y = dy; y < phase.height - dy; y += 1 + dy)
    for (int x = dx; x < phase.width - dx; x += 1 + dx) {
      const std::size_t at[3] = {phase.index(x - dx, y - dy), phase.index(x, y), phase.index(x + dx, y + dy)};
      const double weight[3] = {1.0, -2.0, 1.0};
      double second = 0.0, sigma2 = 0.0;
      bool valid = true;
      for (int k = 0; k < 3; ++k) {
        valid = valid && flags.data[at[k]] == measure::kValid;
        second += weight[k] * static_cast<double>(phase.data[at[k]]);
        sigma2 += weight[k] * weight[k] * static_cast<double>(variance.data[at[k]]);
      }
      second = std::remainder(second, 2.0 * std::numbers::pi);
      if (!valid || !std::isfinite(second) || !(sigma2 > 0.0)) continue;
      NoiseSample s;
      s.noise_dn = static_cast<float>(second / std::sqrt(sigma2));
      s.block = calib::block_of(x, y, phase.width, phase.height);
      z.push_back(s);
      measured.push_back(static_cast<float>(std::abs(second) / std::sqrt(6.0)));
      predicted.push_back(static_cast<float>(std::sqrt(sigma2 / 6.0)));
    }
  const Spread spread = spread_of(z);
  row.phase_ratio = spread.value;
  row.phase_ratio_sigma = spread.sigma;
  row.n_phase = spread.n;
  const bool known = std::isfinite(spread.value);
  row.phase_measured_rad = known ? kMadToSigma * upper_median(measured) : kNaN;
  row.phase_predicted_rad = known ? kMadToSigma * median_of_normals(predicted) : kNaN;
}

}  // namespace

double sensor_variance_dn2(const Sensor& sensor, double dn) {
  double v = kRoundingVariance;
  if (sensor.electrons_per_dn) {
    const double light = std::max(sensor.response.inverse(dn - sensor.black_level_dn), 0.0);
    v += std::pow(sensor.response.slope(light), 2) * light / *sensor.electrons_per_dn;
  }
  const double read = sensor.read_noise_dn.value_or(0.0);
  return v + read * read;
}

std::vector<NoiseRow> noise_rows(const Camera& camera, const Fringes& fringes, const CameraImages& real,
                                 const measure::CameraDecode& decode, const std::vector<int>& used_steps,
                                 const CameraImages* irradiance) {
  std::vector<NoiseRow> rows;
  if (real.radiance || fringes.steps < 3) return rows;
  const std::vector<int> steps = used_steps.empty() ? measure::all_steps(fringes.steps) : used_steps;
  const measure::StepSolver decoded(steps, fringes.steps);
  for (std::size_t k = 0; k < decode.directions.size(); ++k) {
    const measure::DirectionDecode& d = decode.directions[k];
    if (d.wrapped_rad.empty()) continue;
    NoiseRow row;
    row.camera = camera.name;
    row.direction = axis_name(d.axis);
    row.sensor_known = camera.sensor.has_noise();
    row.steps = fringes.steps;
    const auto images =
        measure::collect_direction(real, fringes, static_cast<int>(k), measure::all_steps(fringes.steps));
    row.source = fringes.steps > 3 ? "steps" : images.steps.size() > 1 ? "pitches" : "neighbours";
    if (!check_gray(camera, images.steps, d.axis, real, decode.flags, row)) continue;
    ImageF shape;
    if (irradiance)
      shape = exact_phase(
          measure::collect_direction(*irradiance, fringes, static_cast<int>(k), steps).steps[d.finest],
          decoded);
    check_phase(camera, d, decode.flags, decoded, shape, row);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace fringetwin::compare
