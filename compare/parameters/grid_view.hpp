// SPDX-License-Identifier: Apache-2.0
// Renders a camera on every k-th pixel only, which is what a changed twin would show at 1/k^2 of the cost,
// and holds the real gray values of these pixels.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "render/renderer.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Stands for the pixels (first_x + k i, first_y + k j) of a camera.
struct GridView {
  int stride = 1, first_x = 0, first_y = 0;
  int width = 0, height = 0;  ///< of the grid
  int keep = 1;               ///< of the grid's pixels every keep-th along each axis is worth keeping
  std::size_t pixel_of(int gx, int gy, int full_width) const {
    return static_cast<std::size_t>(first_y + stride * gy) * static_cast<std::size_t>(full_width) +
           static_cast<std::size_t>(first_x + stride * gx);
  }
};

/// Real gray values of one camera on a grid of pixels. Value of pixel p and image k at [p * images.size() +
/// k].
struct GridSamples {
  std::size_t camera = 0;
  GridView grid;
  std::vector<std::size_t> cell;  ///< of each pixel, in the grid
  std::vector<int> images;        ///< sequence indices
  std::vector<float> real_dn;
  std::vector<float> weight;                   ///< 1 / standard deviation; 0 where not usable
  std::vector<bool> at_texture_edge;           ///< of each pixel: find_texture_edges(); may be empty
  double gain_dn = 1.0, black_level_dn = 0.0;  ///< of the gain fit, and then of whatever is fitted
  /// Gain at which the curves of a camera's gray values are told: it stays as the gain is fitted, so that a
  /// prediction holds with any. 0: that of gain_dn.
  double reference_gain_dn = 0.0;
  double curve_gain_dn() const { return reference_gain_dn > 0.0 ? reference_gain_dn : gain_dn; }
  /// Places in `images` of those whose light is their own: images of a code beside phase steps, which may be
  /// exposed by themselves. Every fit leaves each of them a factor.
  std::vector<std::size_t> lit_apart = {};
  std::vector<double> light = {};  ///< that factor of each of `images`, 1 of the others; empty: all 1
  /// Returns the gray values over black that an irradiance of 1 makes in the k-th of `images`.
  double gain_of(std::size_t k) const { return gain_dn * light_of(k); }
  double light_of(std::size_t k) const { return light.empty() ? 1.0 : light[k]; }
  double rendering_dn = 0.0;    ///< rms rendering error, part of the weights
  Eigen::MatrixXd scatter_dn2;  ///< of RenderingError, of these images; part of the weights
  double scatters_alike = 1.0;  ///< in so many neighbouring pixels of those that are kept
  double known_to = 0.05;       ///< relative standard uncertainty of the noise's variance, of single values
  double mean_known_to = 0.05;  ///< the same on average over the pixels' means: of sums over regions
  /// Returns the variance of the noise of a gray value of this level; empty: the weights stay as they are.
  std::function<double(double)> noise_dn2 = {};
  /// The twin's whole images, irradiance but for an offset, which must outlive the samples; null where they
  /// are rounded to gray values.
  const CameraImages* frame = nullptr;
  std::vector<Eigen::Vector2f>
      projector_px;  ///< that lights each pixel; empty unless find_projector_places()
  /// Of each pixel: irradiance of the room in an image without factors, before the lens's vignetting; empty
  /// unless find_room_light().
  std::vector<float> room_light = {};
  /// Derivatives of the irradiance by each parameter of the group pose, laid out as real_dn, which copies
  /// share; null unless Sensitivity::take_pose_slopes().
  std::shared_ptr<const std::vector<std::vector<float>>> pose_slopes = {};
  /// Of each wave of the raster, by direction, pitch and order: its cosine and its sine in each pixel, per
  /// unit of the wave, which copies share; null unless find_waves().
  std::shared_ptr<const std::vector<std::vector<float>>> waves = {};
  /// The same of the harmonics 2 ... highest_harmonic of each pitch; null unless find_harmonics().
  std::shared_ptr<const std::vector<std::vector<float>>> harmonics = {};
  int highest_harmonic = 1;
  std::size_t n_pixels() const { return cell.size(); }
  /// Returns the variance that bounces leave in a value of the k-th image.
  double scatter_of(std::size_t k) const {
    const auto at = static_cast<Eigen::Index>(k);
    return scatter_dn2.size() > 0 ? scatter_dn2(at, at) : 0.0;
  }
};

/// One image of a pitch: where it stands among the images of the samples, and its step.
struct StepImage {
  std::size_t at;
  double step_rad;
};
/// Returns the phase steps among the images of the samples, a list per pitch and direction.
std::map<std::pair<int, int>, std::vector<StepImage>> steps_of_pitches(const GridSamples& s,
                                                                       const Fringes& fringes);

/// Returns a grid that keeps at most `most` of `n_valid` pixels. It holds every pixel, of which some are
/// kept, where the camera cannot be thinned: lens models that are not perspective, a point spread (it needs
/// the neighbours).
GridView choose_grid(const Camera& camera, std::size_t n_valid, std::size_t most);
/// Returns the part of a grid that holds its pixels in `mask` (size of the camera's image); the whole grid
/// where there are none, or the camera cannot be cut.
GridView cut_to(const GridView& grid, const Camera& camera, const ImageU8& mask);

/// Renders the irradiance images (sequence order, grid size) of camera `index`: the rays of the whole image's
/// own pixels by a fixed Gauss rule of `samples` points, so that two twins are sampled alike and their
/// difference is one of the twins. At 1 rad per pixel 9 points are exact to 1e-6 of the contrast, 4 to 2e-4.
std::vector<ImageF> render_grid(render::Renderer& renderer, const Twin& twin, std::size_t index,
                                const GridView& grid, int samples, std::uint64_t seed = 0);

/// Light over other surfaces is gathered at every eighth pixel of smooth surfaces and interpolated between
/// them: in so many pixels it scatters alike.
inline constexpr double kPixelsOfOneGathering = 64.0;

/// Returns the covariance (sequence order) that the directions of bounces, taken at random, leave in the
/// irradiance of a pixel: its images have the same directions, pixels far from it have others.
/// Empty without bounces.
Eigen::MatrixXd bounce_scatter(render::Renderer& renderer, const Twin& twin, std::size_t index);

}  // namespace fringetwin::compare
