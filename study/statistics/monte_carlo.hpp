// SPDX-License-Identifier: Apache-2.0
// Propagation of distributions (JCGM 101:2008, GUM Supplement 1): what a sample says of a quantity, coverage
// intervals, and the adaptive rule that says when there are enough trials (docs/metrics/study.md, "Monte
// Carlo").
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "study/plan/study_point.hpp"

namespace fringetwin::study {

/// From the first value on: the mean of equal values is that value. Of one value or more.
double mean_of(const std::vector<double>& values);
/// Sample standard deviation, n - 1; NaN of fewer than two.
double deviation_of(const std::vector<double>& values, double mean);

struct Interval {
  double low = 0.0, high = 0.0;
};

/// Of n values (2 or more) an interval of this coverage is the range of all.
bool interval_is_range(std::size_t n, double coverage);
/// Of values in ascending order, 0 < coverage < 1 (JCGM 101, 7.7): as many values below as above.
Interval symmetric_interval(const std::vector<double>& sorted, double coverage);
/// The shortest that holds the same number of values.
Interval shortest_interval(const std::vector<double>& sorted, double coverage);

struct SampleSummary {
  std::size_t n = 0;  ///< values that are numbers
  double mean = 0.0, sigma = 0.0;
  Interval symmetric, shortest;
};
/// NaN (no result) is left out; with fewer than two numbers all is NaN.
SampleSummary summarise(const std::vector<double>& values, double coverage);

/// Half a unit of the last of `digits` significant digits of u (JCGM 101, 7.9.2); u > 0.
double numerical_tolerance(double u, int digits);

struct AdaptiveRule {
  double coverage = 0.95;
  int digits = 2;  ///< significant digits of the standard uncertainty that must be right
  /// Trials of a block; 0: JCGM 101's max(100/(1 - coverage), 10^4).
  std::size_t block_trials = 0;
  std::size_t least_blocks = 2;  ///< JCGM 101: 2

  std::size_t trials_per_block() const;
};

/// Twice the standard deviations of the averages over the blocks, against the tolerance.
struct Convergence {
  std::size_t blocks = 0;
  double tolerance = 0.0;
  double mean = 0.0, sigma = 0.0, low = 0.0, high = 0.0;
  bool reached = false;
};
/// JCGM 101, 7.9.4, for one quantity whose trials are given in their order; an unfinished block is left out.
/// A quantity that is the same in every trial has converged.
Convergence convergence(const std::vector<double>& trials, const AdaptiveRule& rule);

/// Returns how many trials the rule will ask for, going by these, of which there were `trials`: the averages
/// over the blocks scatter as one over the root of their number. Nothing with fewer than four blocks, whose
/// scatter says little, or without scatter; `trials` where the rule is met.
std::optional<std::size_t> trials_foreseen(const Convergence& convergence, std::size_t trials);

/// How it came there: after so many trials the estimates and the convergence.
struct ConvergenceStep {
  std::size_t trials = 0;
  double mean = 0.0, sigma = 0.0;
  Convergence convergence;
};
/// After every block from the second on; of more than `most` blocks some.
std::vector<ConvergenceStep> convergence_steps(const std::vector<double>& trials, const AdaptiveRule& rule,
                                               std::size_t most = 60);

}  // namespace fringetwin::study
