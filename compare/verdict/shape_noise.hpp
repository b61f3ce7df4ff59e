// SPDX-License-Identifier: Apache-2.0
// What the noise of a measured shape adds to the budgets of phase and gray values: neighbours share it, since
// each vertex is told by a window of pixels (docs/metrics/verdict.md, "Explained").
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstddef>

#include "measure/decode/decode_types.hpp"
#include "measure/surface.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// The noise of the shapes that were built from this capture's own images.
struct ShapeNoise {
  measure::SurfaceNoise surface;
  /// Variance of a phase from the steps that the shape was built from over that from the steps that are
  /// compared.
  double of_phase = 1.0;

  /// Returns the leverage of a pixel of this camera, that of the whole surface where nothing is known of the
  /// pixel: the surface is the first camera's.
  double leverage_at(std::size_t camera, std::size_t pixel) const {
    return at(camera, surface.leverage_of_pixel, pixel, surface.leverage);
  }
  /// Returns the relative standard error of the projector's light on a pixel.
  double shading_at(std::size_t camera, std::size_t pixel) const {
    return at(camera, surface.shading_of_pixel, pixel, surface.shading);
  }
  /// Returns the variance of a phase that the shape's noise leaves in a pixel over that of the phase from the
  /// steps that are compared.
  double share_of_phase_at(std::size_t camera, std::size_t pixel) const {
    return leverage_at(camera, pixel) * of_phase;
  }
  /// Returns the standard error of the projector coordinate that the shape's noise leaves in a pixel; `real`:
  /// of the steps that are compared.
  double coordinate_sigma_at(std::size_t camera, const measure::DirectionDecode& real,
                             std::size_t pixel) const {
    return std::sqrt(share_of_phase_at(camera, pixel)) *
           static_cast<double>(real.coordinate_sigma_px.data[pixel]);
  }

 private:
  static double at(std::size_t camera, const ImageF& of_pixel, std::size_t pixel, double mean) {
    const bool is_known = camera == 0 && pixel < of_pixel.size() && !std::isnan(of_pixel.data[pixel]);
    return is_known ? static_cast<double>(of_pixel.data[pixel]) : mean;
  }
};

/// Variance of the mean over a square region over that of a single pixel: 1 where all share the error.
struct RegionShares {
  double depth = 1.0;  ///< of the value at the middle of a quadratic over each pixel's window
  double slope = 1.0;  ///< of its slopes
};

/// Returns what windows of this radius leave in the mean over a square of so many pixels a side, from white
/// noise.
RegionShares region_shares(double radius_px, int region_px);

/// Returns where the projector's image of what a pixel in the middle of this camera sees goes as the depth
/// grows: a unit vector over the axes that have fringes. Without a projector, along the first of these.
Eigen::Vector2d depth_direction(const Twin& twin, std::size_t camera);

/// The noise of a measured shape in one camera's comparison; without one, nothing.
struct ShapeInView {
  const ShapeNoise* noise = nullptr;
  std::size_t camera = 0;
  double ambient = 0.0;  ///< irradiance of the room, which no normal shades
  /// The real side's decode of this camera, whose phases tell how far the shape's noise moves fringes; null:
  /// not known.
  const measure::CameraDecode* real = nullptr;
  /// Of a change of depth, how far it goes along the projector's axes: a unit vector over those that have
  /// fringes.
  Eigen::Vector2d along{1.0, 0.0};
  bool shades = true;  ///< whether its normals' noise is seen: not where each pixel has a factor of its own
};

}  // namespace fringetwin::compare
