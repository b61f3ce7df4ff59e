// SPDX-License-Identifier: Apache-2.0
// Fits a surface to every pixel of a measured depth map from its surroundings: its depth and slopes without
// most of the noise, and what noise is left in them, come out (docs/metrics/measure.md, "Measured shapes").
#pragma once
#include <limits>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin::measure {

/// Fewest points of a window for a quadratic, and for a plane where there are less.
inline constexpr int kQuadraticPoints = 10, kPlanePoints = 5;

/// The depths that one camera's pixels measured.
struct DepthMap {
  ImageD z_mm;                              ///< along the optical axis, NaN = unknown
  ImageF sigma_mm;                          ///< its noise; 0, or no number: unknown
  double step = 0.0;                        ///< lateral step to the next pixel per mm of depth
  static constexpr double kSteepest = 6.0;  ///< depth over lateral step of neighbours on one surface
  /// Returns by how much depths so many pixels apart may differ on one surface, over the depth.
  double steepest(double pixels) const;
  /// Returns whether the two depths, `pixels` apart, may lie on one surface.
  bool joined(double z0, double z1, double pixels, double sigma) const;
};

/// What the surroundings of a pixel say of its surface: 1/z = inverse_depth + slope_x dx + slope_y dy + ...
/// over the pixel grid, in which a plane is linear whatever its tilt.
struct DepthFit {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double inverse_depth = kUnknown;                ///< 1/mm; NaN: no surface here
  double slope_x = kUnknown, slope_y = kUnknown;  ///< 1/mm per px; NaN: too few pixels around to tell
  double curvature = 0.0;  ///< sum of both second derivatives, 1/mm per px^2; 0 of a plane
  /// Variance of inverse_depth over that of the pixel's own: more of it is left of a quiet pixel among noisy
  /// ones than of a noisy one among quiet ones. Of a pixel that has no depth or states no noise: over one
  /// over the mean of 1/variance in its window; where none states any, over that which all share.
  float leverage = 1.0F;
  /// Covariance of the slopes (xx, xy, yy) over that same variance, 1/px^2.
  float slope_xx = 0.0F, slope_xy = 0.0F, slope_yy = 0.0F;
  float radius_px = 0.0F;  ///< of the window; 0: the pixel alone
  bool known() const { return inverse_depth == inverse_depth; }
};

/// An offset within a window.
struct WindowOffset {
  int dx, dy;
  double length;  ///< px
};
/// Returns the offsets of the pixels within this radius.
std::vector<WindowOffset> window_of(double radius_px);

/// Fits a quadratic, robustly, to the pixels within smoothing_px that lie on the surface of the middle one; a
/// plane where there are few; a pixel without a depth is filled where most of its window has one. A pixel
/// counts by one over the variance that the map states of it. With most_smoothing_px > smoothing_px the
/// window of each pixel then grows up to that radius, as far as the quadratics of most of the pixels
/// around it agree within their noise, and its own do roughly (intersection of confidence intervals:
/// Katkovnik, Egiazarian and Astola, "Adaptive window size image de-noising based on intersection of
/// confidence intervals (ICI) rule", J. Math. Imaging and Vision 16, 2002).
Image<DepthFit> fit_depths(const DepthMap& map, double smoothing_px, double most_smoothing_px);

/// The inverse depths of a map, and one over the standard error of each.
struct InverseDepths {
  ImageD value;      ///< 1/mm; NaN: unknown
  ImageF certainty;  ///< mm; 0: the map states no noise, or one that is no positive number

  explicit InverseDepths(const DepthMap& map);
  /// Returns the variance of a pixel whose noise is stated.
  double variance(int x, int y) const {
    const auto sure = static_cast<double>(certainty(x, y));
    return 1.0 / (sure * sure);
  }
};

/// Returns what windows 1.41 times as wide as those of the fits tell: what differs beyond the noise of both
/// is what the windows smooth away, since bias grows with the window. Most windows that grew beyond
/// smoothing_px stopped where a wider one tells another surface, which says nothing of them: such a window
/// has one as much narrower. Unknown where a window tells no quadratic, where half of the other one is
/// missing, or where one of them reaches a step of the map.
Image<DepthFit> other_fits(const DepthMap& map, double smoothing_px, const Image<DepthFit>& fits);

/// Lets windows grow as fit_depths() says, from what is fitted with smoothing_px.
void grow_windows(const InverseDepths& depths, double smoothing_px, double most_smoothing_px,
                  Image<DepthFit>& fits);

}  // namespace fringetwin::measure
