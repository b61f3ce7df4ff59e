// SPDX-License-Identifier: Apache-2.0
// Makes what is projected: the images of the sequence and even fields, pixel for pixel.
#pragma once
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

/// One picture for the projector.
struct Pattern {
  int index = -1;      ///< of the sequence; -1: an even field of `level`
  double level = 0.0;  ///< fraction of full scale, for an even field
  std::string label;   ///< for messages and records, e.g. "x pitch 13 step 2/4" (of 1...N), "white"
};

inline Pattern even_field(double level, const std::string& label) { return {-1, level, label}; }
/// The twin's sequence, in order.
std::vector<Pattern> sequence_patterns(const Fringes& fringes);

/// Values as a fraction of full scale at the centres of the projector's pixels (docs/CONVENTIONS.md,
/// "Fringes"), before response and blur: these are the projector's doing.
ImageF pattern_levels(const Fringes& fringes, const Pattern& pattern, int width, int height);

/// round(level (2^bits - 1)), bits 8...16.
ImageU16 quantise_levels(const ImageF& levels, int bits);

}  // namespace fringetwin::capture
