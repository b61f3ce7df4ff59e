// SPDX-License-Identifier: Apache-2.0
// Tells how rough the surfaces are that an image sees, as measured ones are: by how much the normal and the
// place of a pixel differ from the mean of two pixels on both sides of it. Curvature cancels there.
#pragma once
#include <map>
#include <vector>

#include "render/indirect/seen_image.hpp"

namespace fringetwin::render {

class SurfaceRoughness {
 public:
  /// `step_px`: how far away the two pixels are.
  SurfaceRoughness(const SeenImage& seen, int step_px);

  /// Returns the limits of one surface around a pixel: no narrower than `limits`, and wide enough for most of
  /// what the surface around does.
  SurfaceLimits widened(const SurfaceLimits& limits, int x, int y) const;

 private:
  /// Medians over a tile.
  struct Tile {
    float angle_rad = 0.0F;
    float out_of_plane = 0.0F;  ///< in parts of the distance
  };
  static Tile look_at_tile(const SeenImage& seen, int step_px, int x0, int y0);

  int tiles_across_ = 0;
  std::vector<Tile> tiles_;
};

/// The roughness of one image at the steps that are asked for.
class RoughnessAtSteps {
 public:
  /// The image must outlive this.
  explicit RoughnessAtSteps(const SeenImage& seen) : seen_(seen) {}
  const SurfaceRoughness& at(int step_px);

 private:
  const SeenImage& seen_;
  std::map<int, SurfaceRoughness> known_;
};

/// Of noise, up to so many times the median is usual: 2.7 standard deviations of a normal distribution.
inline constexpr float kUsualMedians = 4.0F;

/// Returns what pixels see as an image. Normals of a surface that is rough within a few pixels, as measured
/// ones are, become the mean around: of its light the pixels' own normals have a part of their own.
/// `around_px`: how far.
SeenImage seen_image(int width, int height, const SeenPlaces& seen, int around_px);

/// Returns whether limits have been made wider than those of smooth surfaces.
inline bool is_rough(const SurfaceLimits& limits, const SurfaceLimits& of_smooth) {
  return limits.least_cosine < of_smooth.least_cosine ||
         limits.most_out_of_plane > of_smooth.most_out_of_plane;
}

}  // namespace fringetwin::render
