// SPDX-License-Identifier: Apache-2.0
// Which image is what: one direction's images out of the sequence.
#pragma once
#include <vector>

#include "measure/decode/decode.hpp"

namespace fringetwin::measure {

/// Pointers into CameraImages::images; bits MSB first whatever the file order.
struct DirectionImages {
  std::vector<std::vector<const ImageF*>> steps;  ///< [pitch][used step]
  std::vector<const ImageF*> bits, inverse;       ///< inverse empty without pairs
  const ImageF* complementary = nullptr;
  const ImageF* complementary_inverse = nullptr;
};

/// Throws UserError(input) on a wrong count or differing sizes, UserError(usage) on fringes that cannot
/// be decoded.
void check_decode_input(const CameraImages& images, const Fringes& fringes);

/// used_steps: numbers n, in the order the step images are returned.
DirectionImages collect_direction(const CameraImages& images, const Fringes& fringes, int direction,
                                  const std::vector<int>& used_steps);

}  // namespace fringetwin::measure
