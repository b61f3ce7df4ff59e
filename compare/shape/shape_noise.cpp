// SPDX-License-Identifier: Apache-2.0
#include "compare/shape/shape_noise.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
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

/// Returns the kernels of a quadratic, or of a plane where the window has too few points for one, as the
/// surfaces are fitted; nothing where it has too few for a plane.
std::optional<WindowKernels> window_kernels(double radius_px) {
  const auto window = measure::window_of(radius_px);
  if (window.size() < static_cast<std::size_t>(measure::kPlanePoints)) return std::nullopt;
  const bool is_plane = window.size() < static_cast<std::size_t>(measure::kQuadraticPoints);
  Eigen::MatrixXd design(static_cast<Eigen::Index>(window.size()), is_plane ? 3 : 6);
  for (std::size_t k = 0; k < window.size(); ++k) {
    const double x = window[k].dx, y = window[k].dy;
    const auto row = static_cast<Eigen::Index>(k);
    design.row(row).head<3>() << 1.0, x, y;
    if (!is_plane) design.row(row).tail<3>() << x * x, x * y, y * y;
  }
  const Eigen::MatrixXd inverse = (design.transpose() * design).inverse();
  const Eigen::MatrixXd response = design * inverse.leftCols<2>();
  const auto r = static_cast<Eigen::Index>(radius_px);
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

/// Returns a radius' place among all of them.
std::size_t place_of(double radius_px) {
  return static_cast<std::size_t>(std::lround(kRadiiPerPx * radius_px));
}

/// Returns what a mean over a region keeps of noise, over that of a pixel's mean.
RegionShares over_pixel(double radius_px) {
  const measure::PixelShares in_pixel = measure::shares_in_pixel(radius_px);
  const RegionShares in_region = region_shares(radius_px, kRegion);
  return {in_region.depth / in_pixel.depth, in_region.slope / in_pixel.slope};
}

/// Returns the shares of regions for the radii of windows that this camera sees; the places of others are not
/// filled in.
std::vector<RegionShares> shares_of_radii(const measure::SurfaceNoise& surface, std::size_t camera) {
  std::vector<bool> seen(place_of(surface.radius_px) + 1);
  seen.back() = true;
  for (const float radius_px : surface.of_camera[camera].radius_px.data) {
    if (std::isnan(radius_px)) continue;
    const std::size_t place = place_of(static_cast<double>(radius_px));
    if (place >= seen.size()) seen.resize(place + 1);
    seen[place] = true;
  }
  std::vector<RegionShares> out(seen.size());
  for (std::size_t place = 0; place < seen.size(); ++place)
    if (seen[place]) out[place] = over_pixel(static_cast<double>(place) / kRadiiPerPx);
  return out;
}

/// Returns, along the projector's axes, twice the covariance of what the shape's noise moves in a camera with
/// the noise of the camera's own phases of the same steps, over the variance of what it moves. (Of compared
/// steps that have a share among those of the shape, the covariance is that times the share.) With the
/// projector, the first camera's phases are the shape: 2. Of two cameras that make it, with noise n and n' of
/// one size, what lights a pixel moves by m (n - n')/(m - m'), where m and m' are what one and the same
/// change of depth moves in either.
std::array<double, 2> followed(const measure::SurfaceNoise& surface, const Twin& twin, std::size_t camera) {
  if (twin.measure.triangulate != Triangulate::stereo)
    return camera == 0 ? std::array{2.0, 2.0} : std::array{0.0, 0.0};
  std::array<double, 2> out{};
  if (camera > 1 || surface.of_camera.size() < 2) return out;
  for (const int axis : {0, 1}) {
    const double own = surface.of_camera[camera].median_moved_px[axis],
                 other = surface.of_camera[1 - camera].median_moved_px[axis];
    if (own != 0.0) out[axis] = 1.0 - other / own;
  }
  return out;
}

/// Returns the place of a pixel's region.
std::size_t region_of(std::size_t pixel, const ImageF& regions, int width) {
  const auto w = static_cast<std::size_t>(width);
  return pixel / w / kRegion * static_cast<std::size_t>(regions.width) + pixel % w / kRegion;
}

/// Returns the mean squares over regions of what smoothing has changed, less those of noise, none below 0.
ImageF beyond_noise(const measure::SmoothedInView& smoothed) {
  const ImageF& value = smoothed.value;
  if (value.empty()) return {};
  ImageF out((value.width + kRegion - 1) / kRegion, (value.height + kRegion - 1) / kRegion, 0.0F);
  std::vector<double> squares(out.size(), 0.0), n(out.size(), 0.0);
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (value.data[i] == 0.0F) continue;  // not known
    const std::size_t region = region_of(i, out, value.width);
    squares[region] += std::pow(static_cast<double>(value.data[i]), 2) -
                       std::pow(static_cast<double>(smoothed.noise.data[i]), 2);
    n[region] += 1.0;
  }
  for (std::size_t r = 0; r < out.size(); ++r)
    if (n[r] > 0.0) out.data[r] = static_cast<float>(std::max(0.0, squares[r] / n[r]));
  return out;
}

/// Returns what smoothing has changed at a pixel, of which the mean squares over regions are given.
SmoothedAt smoothed_at(const measure::SmoothedInView& smoothed, const ImageF& of_regions, std::size_t pixel) {
  if (smoothed.value.empty()) return {};
  return {std::sqrt(static_cast<double>(of_regions.data[region_of(pixel, of_regions, smoothed.value.width)])),
          static_cast<double>(smoothed.value.data[pixel])};
}

}  // namespace

std::size_t ShapeInView::radius_at(std::size_t pixel) const {
  const double radius_px = value_or(mean_radius_px, noise->radius_px, pixel);
  return std::min(shares.size() - 1, place_of(radius_px));
}

double ShapeInView::shading_at(std::size_t pixel) const {
  return noise && shades ? value_or(noise->median_shading, noise->shading, pixel) : 0.0;
}

double ShapeInView::moved_px_at(Axis axis, std::size_t pixel) const {
  const std::size_t k = axis == Axis::x ? 0 : 1;
  if (!noise || !(moves[k] > 0.0)) return 0.0;
  return std::sqrt(moves[k]) * value_or(noise->median_moved_px[k], noise->moved_px[k], pixel);
}

SmoothedAt ShapeInView::smoothed_shading_at(std::size_t pixel) const {
  return shades && noise ? smoothed_at(noise->smoothed_shading, smoothed_shading2, pixel) : SmoothedAt{};
}

SmoothedAt ShapeInView::smoothed_px_at(Axis axis, std::size_t pixel) const {
  const std::size_t k = axis == Axis::x ? 0 : 1;
  return noise ? smoothed_at(noise->smoothed_px[k], smoothed_px2[k], pixel) : SmoothedAt{};
}

ShapeInView shape_in_view(const ShapeNoise* noise, const Twin& twin, std::size_t camera,
                          const measure::CameraDecode* real) {
  if (!noise) return {};
  ShapeInView out{.noise = &noise->surface.of_camera.at(camera),
                  .shares = shares_of_radii(noise->surface, camera),
                  .mean_radius_px = noise->surface.radius_px,
                  .ambient = twin.projector ? twin.projector->ambient : 0.0,
                  .real = real};
  const std::array<double, 2> follows = followed(noise->surface, twin, camera);
  for (const int axis : {0, 1}) out.moves[axis] = std::max(0.0, 1.0 - noise->steps_in_shape * follows[axis]);
  out.smoothed_shading2 = beyond_noise(out.noise->smoothed_shading);
  for (const int axis : {0, 1}) out.smoothed_px2[axis] = beyond_noise(out.noise->smoothed_px[axis]);
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
  if (!shape.noise || !(shape.moves[real.axis == Axis::x ? 0 : 1] > 0.0)) return;
  const double fringe_px = fringe_in_image_px(real);
  if (!std::isfinite(fringe_px)) return;
  const auto both_orders = [&](double radius_px, int order) {  // either chi2 is of an order and its double
    return 0.5 *
           (ripple_gain(radius_px, fringe_px / order) + ripple_gain(radius_px, fringe_px / (2 * order))) /
           measure::shares_in_pixel(radius_px).depth;
  };
  std::map<std::size_t, std::array<double, 2>> gains;  // by radius: of the fringe itself, of the alias order
  std::array<double, 2> sums{};
  double n = 0.0;
  for (std::size_t i = 0; i < interior.size(); i += kEvery) {
    const double variance_px2 = std::pow(static_cast<double>(real.coordinate_sigma_px.data[i]), 2) +
                                std::pow(static_cast<double>(simulated.coordinate_sigma_px.data[i]), 2);
    if (interior.data[i] == 0 || !(variance_px2 > 0.0)) continue;
    const double share = std::pow(shape.moved_px_at(real.axis, i), 2) / variance_px2;
    const std::size_t place = shape.radius_at(i);
    const auto [at, is_new] = gains.try_emplace(place);
    const double radius_px = static_cast<double>(place) / kRadiiPerPx;
    if (is_new) at->second = {both_orders(radius_px, 1), both_orders(radius_px, ripple.order)};
    const std::array<double, 2>& gain = at->second;
    sums[0] += share * gain[0], sums[1] += share * gain[1], n += 1.0;
  }
  if (!(n > 0.0)) return;
  ripple.brightness_chi2 /= 1.0 + sums[0] / n;
  ripple.harmonic_chi2 /= 1.0 + sums[1] / n;
}

}  // namespace fringetwin::compare
