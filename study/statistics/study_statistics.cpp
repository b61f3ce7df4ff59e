// SPDX-License-Identifier: Apache-2.0
#include "study/statistics/study_statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>

#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

/// Sums over the settings that have runs.
struct Sums {
  std::vector<double> means;
  double variance = 0.0, square = 0.0;
  std::size_t repeated = 0;             ///< settings with a variance
  std::map<std::uint64_t, double> off;  ///< seed -> its part in the mean of the means
};

void add(const SettingRuns& runs, Sums* sums) {
  const auto n = static_cast<double>(runs.size());
  std::vector<double> values;
  for (const SeededValue& r : runs) values.push_back(r.value);
  const double mean = mean_of(values);
  double spread = 0.0, square = 0.0;
  for (const SeededValue& r : runs) {
    const double d = r.value - mean;
    sums->off[r.seed] += d / n;
    spread += d * d;
    square += r.value * r.value;
  }
  sums->means.push_back(mean);
  sums->square += square / n;
  if (runs.size() < 2) return;
  sums->variance += spread / (n - 1.0);
  ++sums->repeated;
}

}  // namespace

double student_t_quantile(double p, double dof) {
  FT_CHECK(p > 0.0 && p < 1.0 && dof > 0.0, "a probability and degrees of freedom");
  return boost::math::quantile(boost::math::students_t(dof), p);
}

double chi_square_quantile(double p, double dof) {
  FT_CHECK(p > 0.0 && p < 1.0 && dof > 0.0, "a probability and degrees of freedom");
  return boost::math::quantile(boost::math::chi_squared(dof), p);
}

double fisher_f_quantile(double p, double dof_above, double dof_below) {
  FT_CHECK(p > 0.0 && p < 1.0 && dof_above > 0.0 && dof_below > 0.0, "a probability and degrees of freedom");
  return boost::math::quantile(boost::math::fisher_f(dof_above, dof_below), p);
}

Interval mean_interval(double mean, double standard_error, double dof, double coverage) {
  if (!(dof > 0.0) || std::isnan(standard_error)) return {kNan, kNan};
  const double half = student_t_quantile(0.5 + 0.5 * coverage, dof) * standard_error;
  return {mean - half, mean + half};
}

Interval sigma_interval(double sigma, double dof, double coverage) {
  if (!(dof > 0.0) || std::isnan(sigma)) return {kNan, kNan};
  return {sigma * std::sqrt(dof / chi_square_quantile(0.5 + 0.5 * coverage, dof)),
          sigma * std::sqrt(dof / chi_square_quantile(0.5 - 0.5 * coverage, dof))};
}

GroupStatistics group_statistics(const std::vector<const SettingRuns*>& settings, double coverage) {
  Sums sums;
  GroupStatistics out;
  for (const SettingRuns* runs : settings) {
    if (runs->empty()) continue;
    out.runs += runs->size();
    add(*runs, &sums);
  }
  out.settings = sums.means.size();
  out.seeds = sums.off.size();
  out.mean = out.sigma = out.rms = out.between = kNan;
  out.mean_band = out.sigma_band = {kNan, kNan};
  if (sums.means.empty()) return out;
  const auto n_settings = static_cast<double>(out.settings), n_seeds = static_cast<double>(out.seeds);
  out.mean = mean_of(sums.means);
  out.between = deviation_of(sums.means, out.mean);
  out.rms = std::sqrt(sums.square / n_settings);
  out.band_of_settings = sums.repeated == 0;
  if (out.band_of_settings) {
    out.mean_band = mean_interval(out.mean, out.between / std::sqrt(n_settings), n_settings - 1.0, coverage);
    return out;
  }
  double of_seeds = 0.0;
  for (const auto& [seed, off] : sums.off) of_seeds += (off / n_settings) * (off / n_settings);
  out.mean_band =
      mean_interval(out.mean, std::sqrt(of_seeds * n_seeds / (n_seeds - 1.0)), n_seeds - 1.0, coverage);
  out.sigma = std::sqrt(sums.variance / static_cast<double>(sums.repeated));
  out.sigma_band = sigma_interval(out.sigma, n_seeds - 1.0, coverage);
  return out;
}

RunningMean running_mean(const std::vector<double>& x, const std::vector<double>& y, double coverage) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) order.push_back(i);
  RunningMean out;
  constexpr std::size_t kLeast = 12, kMostBins = 20;
  if (order.size() < kLeast) return out;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  const std::size_t n = order.size();
  const std::size_t bins =
      std::min(kMostBins, std::max(std::size_t{2}, static_cast<std::size_t>(std::sqrt(n))));
  for (std::size_t b = 0; b < bins; ++b) {
    std::vector<double> xs, ys;
    for (std::size_t k = b * n / bins; k < (b + 1) * n / bins; ++k) {
      xs.push_back(x[order[k]]);
      ys.push_back(y[order[k]]);
    }
    const auto size = static_cast<double>(ys.size());
    const double mean = mean_of(ys);
    const Interval band = mean_interval(mean, deviation_of(ys, mean) / std::sqrt(size), size - 1.0, coverage);
    out.x.push_back(mean_of(xs));
    out.mean.push_back(mean);
    out.low.push_back(band.low);
    out.high.push_back(band.high);
  }
  return out;
}

}  // namespace fringetwin::study
