// SPDX-License-Identifier: Apache-2.0
#include "study/statistics/monte_carlo.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

/// The values of a coverage interval span q steps of the sorted sample (JCGM 101, 7.7.1).
std::size_t interval_steps(std::size_t n, double coverage) {
  FT_CHECK(n >= 2 && coverage > 0.0 && coverage < 1.0, "a sample and a probability");
  const auto q = static_cast<std::size_t>(coverage * static_cast<double>(n) + 0.5);
  return std::clamp(q, std::size_t{1}, n - 1);
}

/// Twice the standard deviation of the average.
double twice_average_error(const std::vector<double>& blocks) {
  return 2.0 * deviation_of(blocks, mean_of(blocks)) / std::sqrt(static_cast<double>(blocks.size()));
}

}  // namespace

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v - values[0];
  return values[0] + sum / static_cast<double>(values.size());
}

double deviation_of(const std::vector<double>& values, double mean) {
  if (values.size() < 2) return kNan;
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

bool interval_is_range(std::size_t n, double coverage) { return interval_steps(n, coverage) == n - 1; }

Interval symmetric_interval(const std::vector<double>& sorted, double coverage) {
  const std::size_t n = sorted.size(), q = interval_steps(n, coverage);
  const std::size_t r = std::max((n - q + 1) / 2, std::size_t{1});  // counts from 1; JCGM 101, 7.7.2
  return {sorted[r - 1], sorted[r - 1 + q]};
}

Interval shortest_interval(const std::vector<double>& sorted, double coverage) {
  const std::size_t n = sorted.size(), q = interval_steps(n, coverage);
  std::size_t best = 0;
  for (std::size_t r = 1; r + q < n; ++r)
    if (sorted[r + q] - sorted[r] < sorted[best + q] - sorted[best]) best = r;
  return {sorted[best], sorted[best + q]};
}

SampleSummary summarise(const std::vector<double>& values, double coverage) {
  std::vector<double> sorted;
  for (const double v : values)
    if (!std::isnan(v)) sorted.push_back(v);
  SampleSummary out{sorted.size(), kNan, kNan, {kNan, kNan}, {kNan, kNan}};
  if (out.n < 2) return out;
  out.mean = mean_of(sorted);
  out.sigma = deviation_of(sorted, out.mean);
  std::ranges::sort(sorted);
  out.symmetric = symmetric_interval(sorted, coverage);
  out.shortest = shortest_interval(sorted, coverage);
  return out;
}

double numerical_tolerance(double u, int digits) {
  FT_CHECK(u > 0.0 && digits >= 1, "a standard uncertainty and its digits");
  double exponent = std::floor(std::log10(u));
  // 0.0996 to two digits is 0.10: the rounding may carry into another decade.
  if (std::round(u * std::pow(10.0, digits - 1 - exponent)) >= std::pow(10.0, digits)) ++exponent;
  return 0.5 * std::pow(10.0, exponent - (digits - 1));
}

std::size_t AdaptiveRule::trials_per_block() const {
  if (block_trials > 0) return block_trials;
  const double least = std::ceil(100.0 / (1.0 - coverage) - 1e-9);  // 0.95 is not exact
  return std::max(static_cast<std::size_t>(least), std::size_t{10'000});
}

Convergence convergence(const std::vector<double>& trials, const AdaptiveRule& rule) {
  const std::size_t block = rule.trials_per_block();
  Convergence out{.blocks = trials.size() / block};
  out.tolerance = out.mean = out.sigma = out.low = out.high = kNan;
  if (out.blocks < std::max(rule.least_blocks, std::size_t{2})) return out;
  std::vector<double> means, sigmas, lows, highs;
  for (std::size_t b = 0; b < out.blocks; ++b) {
    const auto part = std::span(trials).subspan(b * block, block);
    const SampleSummary s = summarise({part.begin(), part.end()}, rule.coverage);
    means.push_back(s.mean);
    sigmas.push_back(s.sigma);
    lows.push_back(s.symmetric.low);
    highs.push_back(s.symmetric.high);
  }
  const SampleSummary all = summarise(
      {trials.begin(), trials.begin() + static_cast<std::ptrdiff_t>(out.blocks * block)}, rule.coverage);
  out.mean = twice_average_error(means);
  out.sigma = twice_average_error(sigmas);
  out.low = twice_average_error(lows);
  out.high = twice_average_error(highs);
  out.tolerance = all.sigma > 0.0 ? numerical_tolerance(all.sigma, rule.digits) : 0.0;
  const double worst = std::max({out.mean, out.sigma, out.low, out.high});
  out.reached = worst <= out.tolerance && !std::isnan(out.mean);  // NaN: a block without numbers
  return out;
}

std::optional<std::size_t> trials_foreseen(const Convergence& c, std::size_t trials) {
  constexpr std::size_t kFewestBlocks = 4;
  if (c.reached) return trials;
  const double times = std::pow(std::max({c.mean, c.sigma, c.low, c.high}) / c.tolerance, 2);
  if (c.blocks < kFewestBlocks || !std::isfinite(times)) return std::nullopt;
  const double most = std::ceil(std::max(times, 1.0) * static_cast<double>(trials));
  return most < 1e15 ? std::optional(static_cast<std::size_t>(most)) : std::nullopt;
}

std::vector<ConvergenceStep> convergence_steps(const std::vector<double>& trials, const AdaptiveRule& rule,
                                               std::size_t most) {
  AdaptiveRule any = rule;
  any.least_blocks = 2;
  const std::size_t block = rule.trials_per_block(), blocks = trials.size() / block;
  std::vector<ConvergenceStep> out;
  const std::size_t step = std::max(std::size_t{1}, (blocks + most - 1) / most);
  for (std::size_t h = 2; h <= blocks; h = h == blocks ? blocks + 1 : std::min(h + step, blocks)) {
    const std::vector<double> part(trials.begin(), trials.begin() + static_cast<std::ptrdiff_t>(h * block));
    const SampleSummary s = summarise(part, rule.coverage);
    out.push_back({part.size(), s.mean, s.sigma, convergence(part, any)});
  }
  return out;
}

}  // namespace fringetwin::study
