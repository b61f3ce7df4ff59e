// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/noisy_values.hpp"

#include <algorithm>
#include <cmath>

#include "study/statistics/study_statistics.hpp"

namespace fringetwin::study {
namespace {

constexpr double kIntervalCoverage = 0.95;

}  // namespace

StatisticValue statistic_of(const std::vector<double>& trials, Statistic statistic, double value) {
  StatisticValue out{kNan, kNan, {kNan, kNan}, trials.size()};
  if (trials.size() < 2) return out;
  const auto n = static_cast<double>(trials.size());
  const double mean = mean_of(trials), sigma = deviation_of(trials, mean);
  if (statistic == Statistic::sigma) {
    out.value = sigma;
    out.sigma = sigma / std::sqrt(2.0 * (n - 1.0));
    out.interval = sigma_interval(sigma, n - 1.0, kIntervalCoverage);
    return out;
  }
  out.value = mean;
  out.sigma = sigma / std::sqrt(n);
  if (statistic == Statistic::rms_error) {
    std::vector<double> squares;
    for (const double x : trials) squares.push_back((x - value) * (x - value));
    const double square = mean_of(squares), spread = deviation_of(squares, square);
    out.value = std::sqrt(square);
    out.sigma = out.value > 0.0 ? spread / std::sqrt(n) / (2.0 * out.value) : 0.0;
  }
  out.interval = mean_interval(out.value, out.sigma, n - 1.0, kIntervalCoverage);
  if (statistic == Statistic::rms_error) out.interval.low = std::max(out.interval.low, 0.0);
  return out;
}

bool is_surely_less(const StatisticValue& a, const StatisticValue& b, Statistic statistic) {
  if (!(a.value < b.value) || a.n < 2 || b.n < 2) return false;
  const double p = 0.5 + 0.5 * kIntervalCoverage;
  const auto dof_a = static_cast<double>(a.n - 1), dof_b = static_cast<double>(b.n - 1);
  if (statistic == Statistic::sigma)
    return b.value * b.value > fisher_f_quantile(p, dof_b, dof_a) * a.value * a.value;
  return b.value - a.value > student_t_quantile(p, dof_a + dof_b) * std::hypot(a.sigma, b.sigma);
}

}  // namespace fringetwin::study
