// SPDX-License-Identifier: Apache-2.0
// Estimates how far a texture that changes within a pixel moves its phase: decodes of both sides go in, two
// images of shifts come out (docs/metrics/verdict.md, "Explained").
#pragma once
#include "measure/decode/decode_types.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Holds by how much [rad, finest pitch] a texture that the simulated side lacks moves the phase of a pixel;
/// 0 where no neighbour differs beyond noise. A pixel whose weight w changes linearly sees the fringe d/dx(ln
/// w)/12 px beside its centre.
struct TextureShift {
  ImageF largest_rad;  ///< by the larger difference to the two neighbours, both axes alike
  ImageF signed_rad;   ///< by the central difference: what adds up over a region
};
/// `texture`: what the simulated side's pixels have of their own, null for none. Its factor is one number per
/// pixel, which makes the amplitudes agree and moves no phase, so it is taken out of the simulated amplitude.
/// `pixel_side_px`: of the sensor's pixels, whose area alone a texture changes within.
TextureShift texture_shift(const measure::DirectionDecode& real, const measure::DirectionDecode& simulated,
                           const PixelTexture* texture = nullptr, double pixel_side_px = 1.0);

}  // namespace fringetwin::compare
