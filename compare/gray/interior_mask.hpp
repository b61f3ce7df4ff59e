// SPDX-License-Identifier: Apache-2.0
// Finds the pixels inside a surface, where a comparison says something about light and shape and not about an
// outline.
#pragma once
#include "measure/decode/decode.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// Returns 1 where `mask` is set, so are all eight neighbours, and the coordinate of either side (may be
/// null) runs on smoothly: |x(p+e) - 2 x(p) + x(p-e)| <= max(1 px, 12 sigma) along both axes (12 sigma: five
/// standard errors of that difference); then without the border pixels of what is left.
ImageU8 interior_mask(const ImageU8& mask, const measure::CameraDecode* real,
                      const measure::CameraDecode* simulated);

}  // namespace fringetwin::compare
