// SPDX-License-Identifier: Apache-2.0
// What the pixels of an image see, and which of it lies on one surface.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/indirect/gatherer.hpp"

namespace fringetwin::render {

/// What the pixels of an image see, by pixel.
struct SeenImage {
  int width = 0, height = 0;
  std::vector<std::int32_t> at = {};      ///< index in `places`, -1: nothing
  std::vector<SurfacePlace> places = {};  ///< with the mean normal of the surface around
  std::vector<Eigen::Vector3f> own_normals = {};
  bool sees(std::size_t pixel) const { return at[pixel] >= 0; }
  const SurfacePlace& place(std::size_t pixel) const { return places[static_cast<std::size_t>(at[pixel])]; }
  std::size_t pixel_of(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// By how much a surface may turn between two places, and how far one lies out of the other's plane, in
/// parts of their distance.
struct SurfaceLimits {
  float least_cosine, most_out_of_plane;
  bool of_one_primitive = false;  ///< where limits are wide, another object is another surface
};
inline constexpr SurfaceLimits kSmooth{0.94F, 0.3F};  ///< 20 degrees: light can be interpolated
inline constexpr SurfaceLimits kRough{0.77F, 0.7F};   ///< 40 degrees: noise of a measured surface
inline constexpr SurfaceLimits kNoStep{-1.0F, 0.9F};  ///< 64 degrees: beyond, one lies behind the other
/// Returns whether two places lie on one surface.
bool on_one_surface(const SurfacePlace& a, const SurfacePlace& b, const SurfaceLimits& limits);

}  // namespace fringetwin::render
