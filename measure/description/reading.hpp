// SPDX-License-Identifier: Apache-2.0
// Other readings of a capture set than the one its description gives: fringes described in another way, or
// images in another order. A wrong description is found by trying them (doubts.hpp).
#pragma once
#include <string>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// One way to read a camera's images.
struct Reading {
  /// A clause that names it: `steps in reverse order`, `images 3 and 4 swapped`.
  std::string name = {};
  Fringes fringes;
  /// For every place of the sequence the number of the image that is read there; kNotRecorded where no image
  /// shows the pattern.
  std::vector<int> image_of = {};
  /// Places whose images are read as negatives of what was recorded.
  std::vector<std::size_t> negatives = {};
  /// It moves every coordinate by the same length, so that only a known truth can tell.
  bool shifts_only = false;
  /// It changes places of single images: the phases of the others, and so the residuals or the orders, then
  /// contradict the description, too.
  bool single_images = false;
};

inline constexpr int kNotRecorded = -1;

/// Returns the reading that the description itself gives.
Reading described_reading(const Fringes& fringes);

/// Returns the readings to try, each different from the described one in one thing: direction, bit order,
/// complementary bit (there or not, inverted; there with another code offset), code offset, phase origin (the
/// last two in quarters of a period), order of the steps and pitches, two images exchanged, one image more or
/// less than there should be from some image on.
std::vector<Reading> other_readings(const Fringes& fringes);

/// Returns the images in the order of the sequence as `reading` has it. A phase step that was not recorded is
/// made of the other steps of its pitch and of the mean gray value of another pitch, which are equal; where
/// that cannot be, the image left over takes its place.
CameraImages read_as(const CameraImages& images, const Reading& reading);

}  // namespace fringetwin::measure
