// SPDX-License-Identifier: Apache-2.0
// Computes the differences between predicted and real gray values of every image after the gain fit.
#pragma once
#include <cstddef>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// Returns one row per compared image: (gain E + black) - DN over the values the gain fit may use.
std::vector<GrayRow> gray_rows(const Twin& twin, const GrayPair& pair, const GainFit& fit);

/// Returns (gain E + black) - DN of one image, or of its pixel i; NaN where a value is not usable.
float gray_difference(const GrayPair& pair, const GainFit& fit, int image, std::size_t i);
ImageF gray_difference(const GrayPair& pair, const GainFit& fit, int image);

/// Returns what the fitted sensor would have recorded: clamp(gain E + black, 0, max), unrounded.
ImageF predicted_gray(const GrayPair& pair, const GainFit& fit, int image);

/// Returns the percentile of |value| from a histogram of 4096 bins up to 10 rms (Markov: nothing below 99 %
/// lies beyond), linear within a bin.
double percentile_of_magnitude(const std::vector<float>& values, double rms, double percent);

}  // namespace fringetwin::compare
