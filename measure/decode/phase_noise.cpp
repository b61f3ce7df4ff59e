// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/phase_noise.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr std::size_t kMaxSamples = 200000;
constexpr std::size_t kMinPerBin = 200;
constexpr std::size_t kMaxBins = 24;
constexpr std::size_t kTableSize = 257;

/// Returns the median of chi^2/k by Wilson and Hilferty 1931; k = 1 and 2 exactly (1 % off otherwise).
double median_of_reduced_chi2(int k) {
  if (k == 1) return 0.454936;
  if (k == 2) return 0.693147;
  const double c = 1.0 - 2.0 / (9.0 * k);
  return c * c * c;
}

struct NoiseSample {
  float mean, variance;
};

/// Returns the residual energy of the second difference at one pixel, sum r^2 / (6 (N-3)).
double second_difference_variance(const NoiseInput& in, const StepSolver& solver, std::size_t before,
                                  std::size_t at, std::size_t after) {
  const int n = solver.count();
  double d[64];
  double mean = 0.0, c = 0.0, s = 0.0;
  for (int i = 0; i < n; ++i) {
    const auto& v = in.steps[i]->data;
    d[i] = static_cast<double>(v[before]) - 2.0 * static_cast<double>(v[at]) + static_cast<double>(v[after]);
    mean += static_cast<double>(solver.mean_weights()[i]) * d[i];
    c += static_cast<double>(solver.cos_weights()[i]) * d[i];
    s += static_cast<double>(solver.sin_weights()[i]) * d[i];
  }
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double r = d[i] - (mean + solver.basis_cos(i) * c + solver.basis_sin(i) * s);
    sum += r * r;
  }
  return sum / (6.0 * (n - 3));
}

std::vector<NoiseSample> collect_samples(const std::vector<NoiseInput>& pitches, const StepSolver& solver,
                                         Axis axis, double min_amplitude) {
  const int w = pitches.front().mean->width, h = pitches.front().mean->height;
  // Column patterns vary along camera x (roughly): the stripes run along camera y, and vice versa.
  const int dx = axis == Axis::x ? 0 : 1, dy = axis == Axis::x ? 1 : 0;
  const double wanted = static_cast<double>(w) * h * static_cast<double>(pitches.size()) / kMaxSamples;
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(wanted))));
  std::vector<NoiseSample> samples;
  samples.reserve(kMaxSamples + kMaxSamples / 4);
  for (const NoiseInput& in : pitches) {
    const auto usable = [&](std::size_t i) {
      return static_cast<double>(in.amplitude->data[i]) >= min_amplitude && std::isfinite(in.phase->data[i]);
    };
    for (int y = dy; y < h - dy; y += stride)
      for (int x = dx; x < w - dx; x += stride) {
        const std::size_t before = in.mean->index(x - dx, y - dy), at = in.mean->index(x, y),
                          after = in.mean->index(x + dx, y + dy);
        if (!usable(before) || !usable(at) || !usable(after)) continue;
        const double q = second_difference_variance(in, solver, before, at, after);
        samples.push_back({in.mean->data[at], static_cast<float>(q)});
      }
  }
  return samples;
}

double median_variance(std::span<const NoiseSample> samples) {
  std::vector<float> variances;
  for (const NoiseSample& s : samples) variances.push_back(s.variance);
  return upper_median(variances);
}

}  // namespace

NoiseModel NoiseModel::linear(double offset, double slope, double largest_mean) {
  return tabulated({0.0, largest_mean}, {offset, offset + slope * largest_mean});
}

NoiseModel NoiseModel::tabulated(const std::vector<double>& mean, const std::vector<double>& variance) {
  NoiseModel m;
  m.first_ = mean.front();
  const double range = mean.back() > mean.front() ? mean.back() - mean.front() : 1.0;
  m.per_unit_ = static_cast<double>(kTableSize - 1) / range;
  m.table_.resize(kTableSize);
  std::size_t k = 0;
  for (std::size_t i = 0; i < kTableSize; ++i) {
    const double at = m.first_ + static_cast<double>(i) / m.per_unit_;
    while (k + 2 < mean.size() && mean[k + 1] <= at) ++k;
    if (mean.size() == 1) {
      m.table_[i] = variance.front();
      continue;
    }
    const double f = std::clamp((at - mean[k]) / (mean[k + 1] - mean[k]), 0.0, 1.0);
    m.table_[i] = variance[k] + f * (variance[k + 1] - variance[k]);
  }
  return m;
}

bool estimate_noise(const std::vector<NoiseInput>& pitches, const StepSolver& solver, Axis axis,
                    double min_amplitude, NoiseModel& model) {
  if (solver.count() <= 3 || solver.count() > 64) return false;
  std::vector<NoiseSample> samples = collect_samples(pitches, solver, axis, min_amplitude);
  const std::size_t bins = std::min(kMaxBins, samples.size() / kMinPerBin);
  if (bins == 0) return false;
  std::ranges::sort(samples, [](const NoiseSample& a, const NoiseSample& b) {
    return a.mean != b.mean ? a.mean < b.mean : a.variance < b.variance;
  });

  const double per_median = 1.0 / median_of_reduced_chi2(solver.count() - 3);
  std::vector<double> mean, variance;
  for (std::size_t b = 0; b < bins; ++b) {
    const auto begin = samples.begin() + static_cast<std::ptrdiff_t>(b * samples.size() / bins);
    const auto end = samples.begin() + static_cast<std::ptrdiff_t>((b + 1) * samples.size() / bins);
    const double level = static_cast<double>((begin + (end - begin) / 2)->mean);
    if (!mean.empty() && !(level > mean.back())) continue;  // a flat scene: one level
    mean.push_back(level);
    variance.push_back(per_median * median_variance({begin, end}));
  }
  model = NoiseModel::tabulated(mean, variance);
  return true;
}

}  // namespace fringetwin::measure
