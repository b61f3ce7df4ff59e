// SPDX-License-Identifier: Apache-2.0
// Tells the noise of dark gray values from the images of a code: a pair of image sets goes in, a level and
// the variance there come out. Phase steps tell noise at their own levels alone, and a code's dark values lie
// far below them.
#pragma once
#include <optional>

#include "compare/gray/gray_pair.hpp"

namespace fringetwin::compare {

/// The mean of the gray values that a projected code leaves dark, and their variance, rounding included.
struct DarkNoise {
  double level_dn = 0.0, variance_dn2 = 0.0;
  double sigma_dn2 = 0.0;  ///< standard error of the variance
};

/// Returns it from pixels that are dark in two images of a code beside phase steps: their difference has
/// neither texture nor room light, and its second differences along a row no smooth change between the
/// images. Nothing where there is no such code, or its dark values are cut off at 0.
std::optional<DarkNoise> dark_noise(const GrayPair& pair);

}  // namespace fringetwin::compare
