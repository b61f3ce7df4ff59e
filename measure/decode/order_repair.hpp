// SPDX-License-Identifier: Apache-2.0
// Finds fringe-order errors from the neighbours, mends them by whole periods, and counts them.
#pragma once
#include <functional>
#include <optional>

#include "measure/decode/decode_types.hpp"

namespace fringetwin::measure {

struct OrderRepairOptions {
  double period_px = 1.0;
  int radius_px = 2;       ///< window of (2r+1)^2 pixels
  double near = 0.25;      ///< periods: how near a whole period the jump, how near the majority the result
  double majority = 0.55;  ///< fraction of the window's other valid pixels that must agree with its median
  int min_support = 8;     ///< valid neighbours in the window
  int max_passes = 4;      ///< later passes see the earlier ones' results
  double cycle_px = 0.0;   ///< > 0: a cyclic code repeats after this; one period may lead across its ends
  /// The coordinate of pixel `index` when it must be near `predicted_px`, if its phases allow one. Empty
  /// = one period up or down.
  std::function<std::optional<double>(std::size_t index, double predicted_px)> resolve;
};

/// Mends coordinate_px and returns what it changed. A valid pixel that differs from the median of its window
/// by more than half a period, while the majority of the window agrees with the median, moves by whole
/// periods if that brings it within `near` periods of the median. Anything else - a depth step that is no
/// whole period - stays as it is. Independent of the number of threads.
OrderRepair repair_orders(ImageD& coordinate_px, const OrderRepairOptions& options);

}  // namespace fringetwin::measure
