// SPDX-License-Identifier: Apache-2.0
// Checks the images of a camera against the fringe sequence and sorts them: which image is what.
#pragma once
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Pointers into CameraImages::images; bits MSB first whatever the file order.
struct DirectionImages {
  std::vector<std::vector<const GrayImage*>> steps;  ///< [pitch][used step]
  std::vector<const GrayImage*> bits, inverse;       ///< inverse empty without pairs
  const GrayImage* complementary = nullptr;
  const GrayImage* complementary_inverse = nullptr;
};

/// Throws UserError(input) on a wrong count or differing sizes, UserError(usage) on fringes that cannot
/// be decoded.
void check_decode_input(const CameraImages& images, const Fringes& fringes);

/// Returns the images of one direction. used_steps: numbers n, in the order the step images are returned.
DirectionImages collect_direction(const CameraImages& images, const Fringes& fringes, int direction,
                                  const std::vector<int>& used_steps);

}  // namespace fringetwin::measure
