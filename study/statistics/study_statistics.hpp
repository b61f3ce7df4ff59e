// SPDX-License-Identifier: Apache-2.0
// What repeated runs say of a design: means and scatter with confidence bands (docs/metrics/study.md, "Report
// of a study").
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "study/statistics/monte_carlo.hpp"

namespace fringetwin::study {

/// The value below which Student's t, chi-square, and Fisher's F lie with probability p; dof > 0.
double student_t_quantile(double p, double dof);
double chi_square_quantile(double p, double dof);
double fisher_f_quantile(double p, double dof_above, double dof_below);

/// Of a mean with its standard error; NaN without degrees of freedom.
Interval mean_interval(double mean, double standard_error, double dof, double coverage);
/// Of the true sigma of normal values, given the sample's.
Interval sigma_interval(double sigma, double dof, double coverage);

/// One run of a setting. Runs of different settings with one seed have the same noise.
struct SeededValue {
  std::uint64_t seed = 0;
  double value = 0.0;
};
/// The runs of one setting that have a value.
using SettingRuns = std::vector<SeededValue>;

/// Settings together; what does not exist is NaN.
struct GroupStatistics {
  std::size_t runs = 0, settings = 0, seeds = 0;
  double mean = 0.0;   ///< of the settings' means
  Interval mean_band;  ///< against the seeds; with one seed against the settings
  bool band_of_settings = false;
  double sigma = 0.0;  ///< over the seeds of a setting: rms of the settings'
  Interval sigma_band;
  double rms = 0.0;      ///< of the values from 0: rms of the settings'
  double between = 0.0;  ///< standard deviation of the settings' means
};
/// Settings share their seeds, so averaging over settings does not average their noise: seeds are what is
/// independent. A setting without runs is left out.
GroupStatistics group_statistics(const std::vector<const SettingRuns*>& settings, double coverage);

/// Of scattered points, equally many in each bin along x: mean of x, mean of y and its Student interval.
struct RunningMean {
  std::vector<double> x, mean, low, high;
};
/// Points with NaN are left out; fewer than 12: empty.
RunningMean running_mean(const std::vector<double>& x, const std::vector<double>& y, double coverage);

}  // namespace fringetwin::study
