// SPDX-License-Identifier: Apache-2.0
// Tells which pixels see a reflectivity that changes so steeply within them that no factor per pixel
// describes their gray values (docs/metrics/causes.md, "Edges of a texture").
#pragma once
#include <cstddef>

#include "compare/gray/gray_noise.hpp"
#include "compare/gray/gray_pair.hpp"

namespace fringetwin::compare {

/// A pixel whose reflectivity w changes linearly across it sees the irradiance (1/12 px) dln(w)/dx beside its
/// centre, and so a gray value that is wrong by gain (dE/dx) (dln(w)/dx)/12, another one in every image.
class TextureSteps {
 public:
  /// `usable`: holds gain and black level of the prediction. All arguments must outlive this.
  TextureSteps(const GrayPair& pair, const UsableRange& usable, const GrayNoise& noise)
      : pair_(pair), usable_(usable), noise_(noise) {}

  /// Returns whether that is clearly more than nothing in a gray value of this pixel. False at the image's
  /// border, and where noise may make the difference to the neighbours.
  bool is_steep(std::size_t pixel) const;

 private:
  /// The logarithm of a pixel's reflectivity and the variance that noise gives it.
  struct Weight {
    double log, variance;
  };
  Weight weight_of(std::size_t pixel) const;

  const GrayPair& pair_;
  const UsableRange& usable_;
  const GrayNoise& noise_;
};

}  // namespace fringetwin::compare
