// SPDX-License-Identifier: Apache-2.0
// The median, a quantile or the robust scale of a set of numbers, with the convention it follows in its name.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace fringetwin {

// What all of these share: NaN among the values is left out, infinities count, and no value at all gives NaN.
// They work in the values they are given, which are in another order afterwards.

/// Sigma of a normal distribution over the median of the magnitudes of its values, 1 / Phi^-1(3/4).
inline constexpr double kMadToSigma = 1.4826;

/// Returns the value that stands at `rank` when the values are sorted, rank 0 being the smallest; NaN when
/// there are not that many.
double nth_smallest(std::span<float> values, std::size_t rank);
double nth_smallest(std::span<double> values, std::size_t rank);
double nth_smallest(std::span<std::uint16_t> values, std::size_t rank);

/// Returns the middle value, and the mean of the two in the middle when there is an even number of them.
double median(std::span<double> values);

/// Returns the middle value, and the larger of the two in the middle when there is an even number of them: it
/// is always one of the values, at half the cost of median().
double upper_median(std::span<float> values);
double upper_median(std::span<double> values);

/// Returns the value at rank p (n - 1) of the sorted values, p in [0, 1], interpolated linearly between
/// neighbours (type 7 of Hyndman and Fan, "Sample quantiles in statistical packages", 1996).
double quantile(std::span<float> values, double p);

/// Returns the value at rank p (n - 1), rounded down, of the sorted values, p in [0, 1]: always one of them.
double lower_quantile(std::span<float> values, double p);
double lower_quantile(std::span<double> values, double p);

/// Returns sigma of normally distributed residuals about zero that outliers hardly move: kMadToSigma times
/// the upper median of their magnitudes. The residuals are replaced by their magnitudes.
double mad_sigma(std::span<double> residuals);

}  // namespace fringetwin
