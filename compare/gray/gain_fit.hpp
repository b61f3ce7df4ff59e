// SPDX-License-Identifier: Apache-2.0
// The photoelectric gain: DN_real = gain * E_sim + black, robustly over all usable gray values of one
// camera jointly (docs/metrics/gray.md, "Gain").
#pragma once
#include <string>
#include <vector>

#include "compare/gray/gray_source.hpp"

namespace fringetwin::compare {

struct GainFit {
  GainRow row;
  Usable usable;  ///< which gray values entered
};

/// M-estimator (Huber, k = 1.345) by iteratively reweighted least squares on a fixed subsample, then
/// Newton steps on all values until they move by less than 1 % of a standard error. Standard errors:
/// sandwich over blocks of 32x32 pixels, all images of a block together. Sums do not depend on the
/// number of threads. Too few values: row.usable = false, a warning, NaN numbers.
GainFit fit_gain(const GrayPair& pair, std::vector<std::string>& warnings);

}  // namespace fringetwin::compare
