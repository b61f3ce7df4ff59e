// SPDX-License-Identifier: Apache-2.0
// Says which numbers every pixel has of its own beside what a twin predicts for it.
#pragma once

namespace fringetwin::compare {

/// A factor (texture, shading) and an offset (room light, scattering) of each pixel.
struct OwnKinds {
  bool factor = false, offset = false;
  bool any() const { return factor || offset; }
};

}  // namespace fringetwin::compare
