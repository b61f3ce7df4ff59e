// SPDX-License-Identifier: Apache-2.0
// Statistics of trials with their 95 % intervals, and which of two the trials tell apart
// (docs/metrics/study.md, "Optimise").
#pragma once
#include <cstddef>
#include <vector>

#include "study/plan/study_point.hpp"
#include "study/statistics/monte_carlo.hpp"

namespace fringetwin::study {

enum class Statistic { sigma, mean, rms_error };

/// A statistic of n trials with its standard error and the interval that holds the true value in 95 of 100
/// cases.
struct StatisticValue {
  double value = 0.0, sigma = 0.0;
  Interval interval{kNan, kNan};
  std::size_t n = 0;
};
/// Returns the statistic of the trials. The standard error of sigma is that of normal deviates,
/// sigma / sqrt(2 n - 2), its interval that of chi-square; the others have Student's. NaN of less than two
/// values, or with a NaN.
StatisticValue statistic_of(const std::vector<double>& trials, Statistic statistic, double value = 0.0);

/// Returns true where `a` is less than `b` by more than the chance of independent trials: of sigmas by
/// Fisher's F, of the others by Student's t, 97.5 % on this side.
bool is_surely_less(const StatisticValue& a, const StatisticValue& b, Statistic statistic);

}  // namespace fringetwin::study
