// SPDX-License-Identifier: Apache-2.0
// What the noise of measured points leaves in the surface that is fitted to them, as the cameras see it: the
// light that it catches, and the place on the projector that lights it (docs/metrics/measure.md, "Measured
// shapes").
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// What windows have smoothed away of a number, as windows of another size tell it (depth_fit.hpp), and the
/// standard error of that. 0: not known.
struct Smoothed {
  double value = 0.0, noise = 0.0;
  Smoothed times(double factor) const { return {factor * value, std::abs(factor) * noise}; }
};
/// The same of the pixels of a camera.
struct SmoothedInView {
  ImageF value, noise;
  void set_size(const Lens& lens);
  void put(int x, int y, const Smoothed& smoothed);
};

/// What noise a camera's pixels see in a surface; NaN where they see no vertex.
struct SurfaceNoiseInView {
  ImageF shading;  ///< relative standard error of the projector's light; NaN, too, where it does not shine
  /// By how much the place on the projector that lights the pixel moves, px along columns and along rows,
  /// when the surface lies further away by its standard error. Empty without a projector, and where no
  /// fringes vary along the axis.
  std::array<ImageF, 2> moved_px;
  /// By how much smoothing has changed the projector's light, relative, and the place on the projector that
  /// lights the pixel, px along columns and along rows.
  SmoothedInView smoothed_shading;
  std::array<SmoothedInView, 2> smoothed_px;
  /// Of the window that the vertex was fitted to, in this camera's px: neighbours within share their errors.
  ImageF radius_px;
  double median_shading = 0.0;
  std::array<double, 2> median_moved_px{};
};

/// What the noise of the measured points leaves in a surface, over the vertices that the projector lights.
struct SurfaceNoise {
  double leverage = 1.0;   ///< mean variance of a vertex' inverse depth over the mean of its own pixel's
  double radius_px = 0.0;  ///< mean radius of the windows
  std::vector<SurfaceNoiseInView> of_camera = {};
};

/// A vertex of a surface in the world frame, and what noise the pixel has that it is the middle of.
struct VertexNoise {
  Eigen::Vector3d p_mm, normal;  ///< the normal of any length
  /// Standard error of the mean over a pixel, along the axis of the camera that measured it.
  double depth_mm = 0.0;
  double shading = 0.0;  ///< relative, of the projector's light; NaN where it does not shine
  Smoothed smoothed_depth_mm = {}, smoothed_shading = {};
  double radius_px = 0.0;  ///< of its window, px of the camera that measured it
};

/// Returns the lateral step to the next pixel in the middle of a camera's image per depth; 0.001 where its
/// lens sees nothing there.
double lateral_step(const Lens& lens);

/// Writes what one camera sees of the vertices that another one measured, or itself.
class NoiseInView {
 public:
  NoiseInView(const Twin& twin, std::size_t camera, std::size_t measured_by);

  /// Writes a vertex into the pixel that sees it, or the four around where it lies between pixels, unless
  /// what they have hides it or, on the same surface, lies nearer to the pixel's middle. `q_px`: where the
  /// camera sees it, if that is known.
  void add(const VertexNoise& vertex, std::optional<Eigen::Vector2d> q_px = {});

  /// Returns what was written, with its medians.
  SurfaceNoiseInView finish() &&;

 private:
  /// Returns whether a vertex at this depth, so far from a pixel's middle, takes the place of what it has.
  bool is_nearer(double depth_mm, double off_px, int x, int y) const;
  /// Returns how far this camera's ray goes on, mm in the world frame, until it meets the surface when that
  /// lies further away by 1 mm of depth of the camera that measured it.
  Eigen::Vector3d further_mm_per_mm(const VertexNoise& vertex) const;
  /// Returns by how much the place that lights the vertex moves then, px along columns and rows.
  Eigen::Vector2d moved_px_per_mm(const VertexNoise& vertex, const Eigen::Vector3d& further) const;

  const Twin& twin_;
  std::size_t camera_;
  Eigen::Vector3d camera_mm_, axis_, measured_by_mm_, axis_measured_by_;  ///< places and axes, world frame
  double px_ratio_ = 1.0;  ///< px of this camera per length at a depth, over those of the one that measured
  double same_surface_ = 0.0;  ///< by which depths on one surface may differ within a pixel, over the depth
  ImageF depth_mm_, off_px_;   ///< of what is written, off_px_ from the pixel's middle
  SurfaceNoiseInView seen_;
};

/// Puts the larger noise of both into each number of `to`, for surfaces of which a pixel may see either.
void put_larger(const SurfaceNoise& from, SurfaceNoise& to);

}  // namespace fringetwin::measure
