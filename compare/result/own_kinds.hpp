// SPDX-License-Identifier: Apache-2.0
// Says which numbers every pixel has of its own beside what a twin predicts for it.
#pragma once

namespace fringetwin::compare {

/// A factor (texture, shading) and an offset (room light, scattering) of each pixel.
struct OwnKinds {
  bool factor = false, offset = false;
  bool any() const { return factor || offset; }
};

/// What every pixel has of its own and no parameter therefore explains: a factor (texture, shading, light
/// that varies), an offset (room light, scattering). It is projected out of the pixel's values and columns.
enum class FreePerPixel { nothing, factor, offset, factor_and_offset };
inline bool frees_factor(FreePerPixel f) {
  return f == FreePerPixel::factor || f == FreePerPixel::factor_and_offset;
}
inline bool frees_offset(FreePerPixel f) {
  return f == FreePerPixel::offset || f == FreePerPixel::factor_and_offset;
}
inline FreePerPixel free_per_pixel(const OwnKinds& own) {
  if (own.factor) return own.offset ? FreePerPixel::factor_and_offset : FreePerPixel::factor;
  return own.offset ? FreePerPixel::offset : FreePerPixel::nothing;
}
/// Returns what is free where one of the two frees it.
inline FreePerPixel together(FreePerPixel a, FreePerPixel b) {
  return free_per_pixel(
      {.factor = frees_factor(a) || frees_factor(b), .offset = frees_offset(a) || frees_offset(b)});
}

}  // namespace fringetwin::compare
