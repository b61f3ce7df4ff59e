// SPDX-License-Identifier: Apache-2.0
#include "twin/base/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "twin/base/constants.hpp"

namespace fringetwin {
namespace {

/// Moves NaN to the end and returns what stands before it. Without NaN nothing moves.
template <class T>
std::span<T> known(std::span<T> values) {
  if constexpr (std::is_floating_point_v<T>) {
    const auto end = std::partition(values.begin(), values.end(), [](T v) { return !std::isnan(v); });
    return values.first(static_cast<std::size_t>(end - values.begin()));
  } else {
    return values;
  }
}

/// Returns the value at `rank` of values without NaN, and leaves those above it behind it.
template <class T>
double at_rank(std::span<T> values, std::size_t rank) {
  if (rank >= values.size()) return kNaN;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

template <class T>
double middle(std::span<T> values) {
  const std::span<T> some = known(values);
  return at_rank(some, some.size() / 2);
}

/// p (n - 1) for n values.
double rank_of(double p, std::size_t n) { return p * static_cast<double>(n - 1); }

template <class T>
double floor_quantile(std::span<T> values, double p) {
  const std::span<T> some = known(values);
  return some.empty() ? kNaN : at_rank(some, static_cast<std::size_t>(rank_of(p, some.size())));
}

}  // namespace

double nth_smallest(std::span<float> values, std::size_t rank) { return at_rank(known(values), rank); }
double nth_smallest(std::span<double> values, std::size_t rank) { return at_rank(known(values), rank); }
double nth_smallest(std::span<std::uint16_t> values, std::size_t rank) {
  return at_rank(known(values), rank);
}

double median(std::span<double> values) {
  const std::span<double> some = known(values);
  const std::size_t half = some.size() / 2;
  const double upper = at_rank(some, half);
  if (some.empty() || some.size() % 2 == 1) return upper;
  return 0.5 * (*std::max_element(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(half)) + upper);
}

double upper_median(std::span<float> values) { return middle(values); }
double upper_median(std::span<double> values) { return middle(values); }

double quantile(std::span<float> values, double p) {
  const std::span<float> some = known(values);
  if (some.empty()) return kNaN;
  const double rank = rank_of(p, some.size());
  const auto whole = static_cast<std::size_t>(rank);
  const double below = at_rank(some, whole), fraction = rank - static_cast<double>(whole);
  if (fraction == 0.0) return below;
  const std::span<float> above = some.subspan(whole + 1);
  return below + fraction * (static_cast<double>(*std::ranges::min_element(above)) - below);
}

double lower_quantile(std::span<float> values, double p) { return floor_quantile(values, p); }
double lower_quantile(std::span<double> values, double p) { return floor_quantile(values, p); }

double mad_sigma(std::span<double> residuals) {
  for (double& r : residuals) r = std::abs(r);
  return kMadToSigma * upper_median(residuals);
}

}  // namespace fringetwin
