// SPDX-License-Identifier: Apache-2.0
// Fits the photoelectric gain and the black level of one camera, DN_real = gain * E_sim + black, robustly
// over all usable gray values jointly (docs/metrics/gray.md, "Gain").
#pragma once
#include <string>
#include <vector>

#include "compare/gray/gray_pair.hpp"

namespace fringetwin::compare {

/// The gain of one camera.
struct GainFit {
  GainRow row;
  UsableRange usable;  ///< which gray values entered
};

/// Minimises an M-estimator (Huber, k = 1.345) by iteratively reweighted least squares on a fixed subsample,
/// then Newton steps on all values until they move by less than 1 % of a standard error. Standard errors:
/// sandwich over blocks of 32x32 pixels, all images of a block together. Sums do not depend on the
/// number of threads. Too few values: row.usable = false, a warning, NaN numbers.
GainFit fit_gain(const GrayPair& pair, std::vector<std::string>& warnings);

}  // namespace fringetwin::compare
