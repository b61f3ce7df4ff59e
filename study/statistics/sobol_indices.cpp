// SPDX-License-Identifier: Apache-2.0
#include "study/statistics/sobol_indices.hpp"

#include <algorithm>
#include <cmath>

#include "study/plan/random_draws.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

struct Estimate {
  double variance = 0.0;
  std::vector<double> first, total;
};

/// From these rows, which may repeat.
Estimate estimate(const SobolSample& s, const std::vector<std::size_t>& rows) {
  const auto n = static_cast<double>(rows.size());
  const double origin = s.a[rows[0]];  // a result that does not vary has a variance of exactly 0
  double sum = 0.0, square = 0.0;
  for (const std::size_t i : rows) sum += (s.a[i] - origin) + (s.b[i] - origin);
  const double mean = origin + sum / (2.0 * n);
  for (const std::size_t i : rows)
    square += (s.a[i] - mean) * (s.a[i] - mean) + (s.b[i] - mean) * (s.b[i] - mean);
  Estimate out;
  out.variance = square / (2.0 * n - 1.0);
  for (const std::vector<double>& ab : s.a_with_b) {
    double first = 0.0, total = 0.0;
    for (const std::size_t i : rows) {
      // The mean taken off: the estimate does not change, its scatter does, where it is large against sigma.
      first += (s.b[i] - mean) * (ab[i] - s.a[i]);
      total += (s.a[i] - ab[i]) * (s.a[i] - ab[i]);
    }
    out.first.push_back(first / n / out.variance);
    out.total.push_back(total / (2.0 * n) / out.variance);
  }
  return out;
}

std::vector<std::size_t> complete_rows(const SobolSample& s) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < s.a.size(); ++i) {
    bool complete = !std::isnan(s.a[i]) && !std::isnan(s.b[i]);
    for (const std::vector<double>& ab : s.a_with_b) complete = complete && !std::isnan(ab[i]);
    if (complete) rows.push_back(i);
  }
  return rows;
}

/// Per factor, the intervals of the resampled indices in `draws` [factor][resample].
std::vector<SobolIndex> with_intervals(const std::vector<double>& values,
                                       std::vector<std::vector<double>>& draws, double coverage) {
  std::vector<SobolIndex> out;
  for (std::size_t f = 0; f < values.size(); ++f) {
    std::ranges::sort(draws[f]);
    out.push_back({values[f], symmetric_interval(draws[f], coverage)});
  }
  return out;
}

}  // namespace

SobolIndices sobol_indices(const SobolSample& sample, double coverage, std::uint64_t seed,
                           std::size_t resamples) {
  FT_CHECK(sample.b.size() == sample.a.size(), "as many rows of b as of a");
  for (const std::vector<double>& ab : sample.a_with_b)
    FT_CHECK(ab.size() == sample.a.size(), "as many rows of every factor as of a");
  FT_CHECK(resamples >= 2, "at least two resamples");
  const std::vector<std::size_t> rows = complete_rows(sample);
  const std::size_t factors = sample.a_with_b.size();
  SobolIndices out{.rows = rows.size(), .variance = kNan};
  out.first.assign(factors, {kNan, {kNan, kNan}});
  out.total = out.first;
  if (rows.size() < 2) return out;
  const Estimate whole = estimate(sample, rows);
  out.variance = whole.variance;
  if (!(whole.variance > 0.0)) return out;

  std::vector<std::vector<double>> first(factors), total(factors);
  std::vector<std::size_t> drawn(rows.size());
  for (std::size_t k = 0; k < resamples; ++k) {
    for (std::size_t i = 0; i < rows.size(); ++i)
      drawn[i] =
          rows[random_bits(seed, DrawStream::bootstrap, k, static_cast<std::uint32_t>(i)) % rows.size()];
    const Estimate e = estimate(sample, drawn);
    if (!(e.variance > 0.0)) continue;  // one row drawn over and over
    for (std::size_t f = 0; f < factors; ++f) {
      first[f].push_back(e.first[f]);
      total[f].push_back(e.total[f]);
    }
  }
  if (factors == 0 || first[0].size() < 2) return out;
  out.first = with_intervals(whole.first, first, coverage);
  out.total = with_intervals(whole.total, total, coverage);
  return out;
}

}  // namespace fringetwin::study
