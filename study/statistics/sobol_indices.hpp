// SPDX-License-Identifier: Apache-2.0
// Which input a spread comes from: first-order and total Sobol indices with bootstrap intervals
// (docs/metrics/study.md, "Sensitivity").
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "study/statistics/monte_carlo.hpp"

namespace fringetwin::study {

/// One result at two independent samples of all inputs, row by row, and at `a` with the factor's inputs taken
/// from `b`. A factor may be a group of inputs (all numbers of a calibration), as long as groups are
/// independent of each other.
struct SobolSample {
  std::vector<double> a, b;
  std::vector<std::vector<double>> a_with_b;  ///< per factor
};

struct SobolIndex {
  double value = 0.0;
  Interval interval;
};

struct SobolIndices {
  std::size_t rows = 0;  ///< of which all results are numbers; others are left out
  double variance = 0.0;
  /// Per factor: share of the variance that goes with the factor alone; that it has any part in.
  std::vector<SobolIndex> first = {}, total = {};
};

/// first: Saltelli et al. 2010, (1/N) sum f(b) (f(ab) - f(a)) / V, results taken from their mean; total:
/// Jansen 1999, (1/2N) sum (f(a) - f(ab))^2 / V. Intervals: rows drawn with replacement. A result that does
/// not vary, or fewer than two rows: all NaN.
SobolIndices sobol_indices(const SobolSample& sample, double coverage, std::uint64_t seed,
                           std::size_t resamples = 1000);

}  // namespace fringetwin::study
