// SPDX-License-Identifier: Apache-2.0
// Shift between real and simulated images of one camera: the numbers.
#pragma once
#include <cstdint>
#include <string>

#include "twin/image/image.hpp"

namespace fringetwin::compare {

inline constexpr int kShiftBlock = 32;

/// One component over the blocks that tell it; NaN when none does.
struct ShiftComponent {
  double mean_px = 0, mean_sigma_px = 0, rms_px = 0, largest_px = 0;
  std::uint64_t n_blocks = 0;
};

/// The simulated image moved by (dx, dy) lies on the real one.
struct ShiftRow {
  std::string camera;
  ShiftComponent dx, dy;
  double chi2_before = 0, chi2_after = 0;  ///< per degree of freedom, of blocks that tell a component
  std::uint64_t n = 0;                     ///< gray values
  ImageF dx_px, dy_px;                     ///< one value per block; NaN where unknown
};

}  // namespace fringetwin::compare
