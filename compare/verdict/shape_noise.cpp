// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/shape_noise.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "measure/depth_fit.hpp"
#include "measure/surface.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;

/// Returns the sum of squares of a kernel's sums over a square that slides over it, over n^4 times its own:
/// the mean over n^2 pixels sees each value of the noise with the kernel's sum over the square.
double share_of(const Eigen::MatrixXd& kernel, int region_px) {
  const Eigen::Index size = kernel.rows(), n = region_px;
  double sum = 0.0;
  for (Eigen::Index y = 1 - n; y < size; ++y)
    for (Eigen::Index x = 1 - n; x < size; ++x) {
      const Eigen::Index x0 = std::max<Eigen::Index>(x, 0), y0 = std::max<Eigen::Index>(y, 0);
      const Eigen::Index w = std::min(x + n, size) - x0, h = std::min(y + n, size) - y0;
      const double s = kernel.block(y0, x0, h, w).sum();
      sum += s * s;
    }
  return sum / (std::pow(static_cast<double>(n), 4) * kernel.squaredNorm());
}

/// What the smoothing of a window makes of its points, in the pixel in the middle.
struct WindowKernels {
  Eigen::MatrixXd depth, slope;  ///< of the value, and of the slope along x
};

/// Returns the kernels of a quadratic; nothing where the window has too few points for one.
std::optional<WindowKernels> window_kernels(double radius_px) {
  const auto window = measure::window_of(std::max(0.0, std::floor(radius_px + 0.5)));
  if (window.size() < static_cast<std::size_t>(measure::kQuadraticPoints)) return std::nullopt;
  Eigen::MatrixXd design(static_cast<Eigen::Index>(window.size()), 6);
  for (std::size_t k = 0; k < window.size(); ++k) {
    const double x = window[k].dx, y = window[k].dy;
    design.row(static_cast<Eigen::Index>(k)) << 1.0, x, y, x * x, x * y, y * y;
  }
  const Eigen::Matrix<double, 6, 6> inverse = (design.transpose() * design).inverse();
  const Eigen::MatrixXd response = design * inverse.leftCols<2>();
  const auto r = static_cast<Eigen::Index>(std::lround(radius_px));
  WindowKernels out{Eigen::MatrixXd::Zero(2 * r + 1, 2 * r + 1), Eigen::MatrixXd::Zero(2 * r + 1, 2 * r + 1)};
  for (std::size_t k = 0; k < window.size(); ++k) {
    out.depth(window[k].dy + r, window[k].dx + r) = response(static_cast<Eigen::Index>(k), 0);
    out.slope(window[k].dy + r, window[k].dx + r) = response(static_cast<Eigen::Index>(k), 1);
  }
  return out;
}

/// Returns the period of the finest fringes in the camera's image, px: the median over pixels; NaN where too
/// few are decoded.
double fringe_in_image_px(const DirectionDecode& real) {
  constexpr int kApart = 4;  // px, over which noise counts little
  constexpr std::size_t kFewest = 100;
  const ImageD& at_px = real.coordinate_px;
  std::vector<double> per_px;
  for (int y = 0; y + kApart < at_px.height; y += 3)
    for (int x = 0; x + kApart < at_px.width; x += 3) {
      const double here_px = at_px(x, y);
      const double slope = std::hypot(at_px(x + kApart, y) - here_px, at_px(x, y + kApart) - here_px);
      if (std::isfinite(slope) && slope > 0.0) per_px.push_back(slope / kApart);
    }
  return per_px.size() < kFewest ? kNaN : real.pitches_px[real.finest] / upper_median(per_px);
}

/// Returns the pixel's value where it has one.
double value_or(double otherwise, const ImageF& of_pixel, std::size_t pixel) {
  const bool has_value = pixel < of_pixel.size() && !std::isnan(of_pixel.data[pixel]);
  return has_value ? static_cast<double>(of_pixel.data[pixel]) : otherwise;
}

/// Returns the shares of regions for all radii of windows that this camera sees.
std::vector<RegionShares> shares_of_radii(const measure::SurfaceNoise& surface, std::size_t camera) {
  float largest_px = 0.0F;
  for (const float radius_px : surface.of_camera[camera].radius_px.data)
    largest_px = std::fmax(largest_px, radius_px);  // NaN: none
  std::vector<RegionShares> out;
  for (int radius_px = 0; radius_px <= std::lround(largest_px); ++radius_px) {
    const measure::PixelShares in_pixel = measure::shares_in_pixel(radius_px);
    out.push_back(region_shares(radius_px, kRegion));
    out.back().depth /= in_pixel.depth, out.back().slope /= in_pixel.slope;
  }
  return out;
}

/// Returns twice the covariance of what the shape's noise moves in a camera with the noise of the camera's
/// own phases of the same steps, over the variance of what it moves. (Of N compared steps that have a share
/// among those of the shape, the covariance is that times the share.) With the projector, the first camera's
/// phases are the shape: 2. Of two cameras that make it with noise n and n', what lights a pixel moves by m
/// (n - n')/(m - m'), where m and m' are what one and the same change of depth moves in either.
double followed(const measure::SurfaceNoise& surface, const Twin& twin, std::size_t camera) {
  if (twin.measure.triangulate != Triangulate::stereo) return camera == 0 ? 2.0 : 0.0;
  if (camera > 1 || surface.of_camera.size() < 2) return 0.0;
  const auto &own = surface.of_camera[camera].median_moved_px,
             &other = surface.of_camera[1 - camera].median_moved_px;
  const std::size_t axis = std::abs(own[0]) >= std::abs(own[1]) ? 0 : 1;
  return own[axis] != 0.0 ? 1.0 - other[axis] / own[axis] : 0.0;
}

}  // namespace

std::size_t ShapeInView::radius_at(std::size_t pixel) const {
  const double radius_px = value_or(mean_radius_px, noise->radius_px, pixel);
  return std::min(shares.size() - 1, static_cast<std::size_t>(std::lround(radius_px)));
}

double ShapeInView::shading_at(std::size_t pixel) const {
  return noise && shades ? value_or(noise->median_shading, noise->shading, pixel) : 0.0;
}

double ShapeInView::moved_px_at(Axis axis, std::size_t pixel) const {
  if (!noise || !(moves > 0.0)) return 0.0;
  const std::size_t k = axis == Axis::x ? 0 : 1;
  return std::sqrt(moves) * value_or(noise->median_moved_px[k], noise->moved_px[k], pixel);
}

ShapeInView shape_in_view(const ShapeNoise* noise, const Twin& twin, std::size_t camera,
                          const measure::CameraDecode* real) {
  if (!noise) return {};
  ShapeInView out{.noise = &noise->surface.of_camera.at(camera),
                  .shares = shares_of_radii(noise->surface, camera),
                  .mean_radius_px = noise->surface.radius_px,
                  .ambient = twin.projector ? twin.projector->ambient : 0.0,
                  .real = real};
  out.moves = std::max(0.0, 1.0 - noise->steps_in_shape * followed(noise->surface, twin, camera));
  return out;
}

RegionShares region_shares(double radius_px, int region_px) {
  const std::optional<WindowKernels> kernels = window_kernels(radius_px);
  const double alone = 1.0 / (static_cast<double>(region_px) * region_px);
  if (!kernels) return {alone, alone};
  return {share_of(kernels->depth, region_px), share_of(kernels->slope, region_px)};
}

double ripple_gain(double radius_px, double period_px) {
  const std::optional<WindowKernels> kernels = window_kernels(radius_px);
  if (!kernels) return 1.0;
  double sum = 0.0;
  for (Eigen::Index x = 0; x < kernels->depth.cols(); ++x)
    sum += kernels->depth.col(x).sum() *
           std::cos(kTwoPi * static_cast<double>(x - kernels->depth.cols() / 2) / period_px);
  return sum * sum / kernels->depth.squaredNorm();
}

void count_shape(const ShapeInView& shape, const DirectionDecode& real, const DirectionDecode& simulated,
                 const ImageU8& interior, RippleTest& ripple) {
  constexpr int kEvery = 5;  // pixels: what is asked for is a mean
  if (!shape.noise || !(shape.moves > 0.0)) return;
  const double fringe_px = fringe_in_image_px(real);
  if (!std::isfinite(fringe_px)) return;
  std::vector<std::array<double, 2>> gains;  // by radius: of the fringe itself, and of the alias order
  for (std::size_t k = 0; k < shape.shares.size(); ++k) {
    const auto radius_px = static_cast<double>(k);
    const double in_pixel = measure::shares_in_pixel(radius_px).depth;
    gains.push_back({ripple_gain(radius_px, fringe_px) / in_pixel,
                     ripple_gain(radius_px, fringe_px / ripple.order) / in_pixel});
  }
  std::array<double, 2> sums{};
  double n = 0.0;
  for (std::size_t i = 0; i < interior.size(); i += kEvery) {
    const double variance_px2 = std::pow(static_cast<double>(real.coordinate_sigma_px.data[i]), 2) +
                                std::pow(static_cast<double>(simulated.coordinate_sigma_px.data[i]), 2);
    if (interior.data[i] == 0 || !(variance_px2 > 0.0)) continue;
    const double share = std::pow(shape.moved_px_at(real.axis, i), 2) / variance_px2;
    const std::array<double, 2>& gain = gains[shape.radius_at(i)];
    sums[0] += share * gain[0], sums[1] += share * gain[1], n += 1.0;
  }
  if (!(n > 0.0)) return;
  ripple.brightness_chi2 /= 1.0 + sums[0] / n;
  ripple.harmonic_chi2 /= 1.0 + sums[1] / n;
}

}  // namespace fringetwin::compare
