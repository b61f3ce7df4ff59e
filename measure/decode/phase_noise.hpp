// SPDX-License-Identifier: Apache-2.0
// Models the noise of a gray value as a function of its mean, known or estimated from the N-step residuals.
#pragma once
#include <vector>

#include "measure/decode/phase.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Variance of one gray value against its mean level: a table over equal intervals of the mean, linear
/// between its nodes.
class NoiseModel {
 public:
  /// var = offset + slope * mean, for means in 0...largest_mean.
  static NoiseModel linear(double offset, double slope, double largest_mean);
  /// Nodes (mean, variance) with rising mean; constant beyond the ends.
  static NoiseModel tabulated(const std::vector<double>& mean, const std::vector<double>& variance);

  double variance(double mean) const {
    const double at = (mean - first_) * per_unit_;
    if (!(at > 0.0)) return table_.front();
    if (at >= static_cast<double>(table_.size() - 1)) return table_.back();
    const auto i = static_cast<std::size_t>(at);
    const double f = at - static_cast<double>(i);
    return table_[i] + f * (table_[i + 1] - table_[i]);
  }
  /// Never below `smallest` (quantisation).
  void raise_to(double smallest) {
    for (double& v : table_) v = v < smallest ? smallest : v;
  }

 private:
  double first_ = 0.0, per_unit_ = 1.0;
  std::vector<double> table_{0.0, 0.0};
};

/// One pitch of one direction as the estimator sees it.
struct NoiseInput {
  std::vector<const ImageF*> steps;
  const ImageF* phase = nullptr;  ///< NaN where masked
  const ImageF* amplitude = nullptr;
  const ImageF* mean = nullptr;
};

/// Estimates gray-value noise from the residuals of the N-step fit, N > 3. The fit residual of each step is
/// differentiated twice along the stripes (which removes the projector's harmonics: they are smooth
/// there), so q = sum r^2 / (6 (N-3)) is sigma^2 chi^2/(N-3); pooled over all pitches in up to 24 bins of
/// equal count over the mean level, the bin's variance is its median / median of chi^2/(N-3). Needs
/// at least 200 samples per bin; returns false when there are too few for one bin.
bool estimate_noise(const std::vector<NoiseInput>& pitches, const StepSolver& solver, Axis axis,
                    double min_amplitude, NoiseModel& model);

}  // namespace fringetwin::measure
