// SPDX-License-Identifier: Apache-2.0
// Fits the photoelectric gain and the black level of one camera, DN_real = gain * E_sim + black, robustly
// over all usable gray values jointly (docs/metrics/gray.md, "Gain").
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/gray/gain_start.hpp"
#include "compare/gray/gray_noise.hpp"
#include "compare/gray/gray_pair.hpp"

namespace fringetwin::compare {

/// The gain of one camera; where none can be fitted, a provisional line to judge gray values along.
struct GainFit {
  /// Where row.usable is false, gain_dn and black_level_dn are those of the provisional line, NaN without
  /// one, the other numbers say nothing, and `why` says why no gain is fitted.
  GainRow row;
  UsableRange usable;              ///< which gray values entered
  std::optional<GainStart> start;  ///< what the fit started from; none where the amplitudes tell nothing
  bool has_line() const { return row.gain_dn == row.gain_dn; }
};

/// Minimises an M-estimator (Huber, k = 1.345) by iteratively reweighted least squares on a fixed subsample,
/// from the line of the pixels' own amplitudes, then Newton steps on all values until they move by less than
/// 1 % of a standard error. Standard errors: sandwich over blocks of 32x32 pixels, all images of a block
/// together. Sums do not depend on the number of threads. `noise` says how far values keep away from the
/// clips; without it, or where it knows of rounding only, the scale of the residuals does, up to 1 % of the
/// range.
/// A line that is no gain (too few values; falling; R2 below a half where noise does not explain it; far off
/// the ratio of the amplitudes): row.usable = false and a warning with the reason.
GainFit fit_gain(const GrayPair& pair, std::vector<std::string>& warnings, const GrayNoise* noise = nullptr);

/// Returns the row as a result tells it: without a gain its numbers are NaN and the provisional line has keys
/// of its own.
GainRow published_row(const GainFit& fit);
/// Returns what published_row() was made of, as far as gray values are compared by it.
GainFit fit_of(const GrayPair& pair, const GainRow& published);

}  // namespace fringetwin::compare
