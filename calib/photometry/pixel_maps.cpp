// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/pixel_maps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "twin/base/constants.hpp"

namespace fringetwin::calib {
namespace {

/// Half the side of the square that tells the light around a pixel: the pixel's own share of it, 1/961, is
/// what its factor comes out too near to 1 by.
constexpr int kAroundPx = 15;

/// Repeated images of one light, as mean and temporal variance of each pixel; NaN where a pixel is unknown.
struct Means {
  ImageD mean;
  double variance = 0.0;  ///< temporal, of one image: mean over the pixels
  double variance_of_mean = 0.0;
};

/// Returns by how much rounding moves the mean of many images off, rms over pixels of any level: noise lets
/// little of it be (the first harmonic of the rounding error, e^(-2 pi^2 sigma^2), of all of it without
/// noise).
double rounding_that_stays_dn(double variance_dn2) {
  const double before_rounding = std::max(0.0, variance_dn2 - kRoundingVariance);
  return std::sqrt(kRoundingVariance) *
         std::exp(-2.0 * std::numbers::pi * std::numbers::pi * before_rounding);
}

/// Averages values of pixels over images whose own level `align` has made alike.
/// `value(k, i)`: of image k at pixel i, NaN where unknown; `align(value, level of the image, mean level)`.
template <class Value, class Align>
Means averaged(int width, int height, std::size_t n_images, Value value, Align align) {
  Means out{.mean = ImageD(width, height)};
  const std::size_t n = out.mean.size();
  std::vector<double> level(n_images, 0.0);
  double all = 0.0;
  for (std::size_t k = 0; k < n_images; ++k) {
    std::size_t known = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (const double v = value(k, i); std::isfinite(v)) level[k] += v, ++known;
    level[k] /= static_cast<double>(std::max<std::size_t>(1, known));
    all += level[k] / static_cast<double>(n_images);
  }
  double variance = 0.0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < n_images; ++k) {
      const double v = align(value(k, i), level[k], all);
      sum += v, squares += v * v;
    }
    const auto count = static_cast<double>(n_images);
    out.mean.data[i] = sum / count;
    if (!std::isfinite(sum)) continue;
    variance += std::max(0.0, squares - sum * sum / count) / (count - 1.0);
    ++known;
  }
  out.variance = variance / static_cast<double>(std::max<std::size_t>(1, known));
  out.variance_of_mean = out.variance / static_cast<double>(n_images);
  return out;
}

/// Sums over the rectangle from the first pixel on, so that any rectangle is four of them.
class RectangleSums {
 public:
  template <class At>
  RectangleSums(int width, int height, At at) : sums_(width + 1, height + 1, 0.0) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        sums_(x + 1, y + 1) = at(x, y) + sums_(x, y + 1) + sums_(x + 1, y) - sums_(x, y);
  }
  /// Returns the sum over the square around a pixel, as far as it lies in the image.
  double around(int x, int y) const {
    const int x0 = std::max(0, x - kAroundPx), y0 = std::max(0, y - kAroundPx),
              x1 = std::min(sums_.width - 1, x + kAroundPx + 1),
              y1 = std::min(sums_.height - 1, y + kAroundPx + 1);
    return sums_(x1, y1) - sums_(x0, y1) - sums_(x1, y0) + sums_(x0, y0);
  }

 private:
  ImageD sums_;
};

/// Divides each pixel by the mean of those around it that are known.
void divide_by_what_is_around(ImageD& image) {
  const auto known = [&](int x, int y) { return std::isfinite(image(x, y)); };
  const RectangleSums count(image.width, image.height, [&](int x, int y) { return known(x, y) ? 1.0 : 0.0; });
  const RectangleSums sum(image.width, image.height,
                          [&](int x, int y) { return known(x, y) ? image(x, y) : 0.0; });
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) image(x, y) *= count.around(x, y) / sum.around(x, y);
}

/// Returns mean and standard deviation of what is known.
std::pair<double, double> spread_of(const ImageD& image, std::size_t& n_known) {
  double mean = 0.0, squares = 0.0;
  n_known = 0;
  for (const double v : image.data)
    if (std::isfinite(v)) mean += v, ++n_known;
  mean /= static_cast<double>(n_known);
  for (const double v : image.data)
    if (std::isfinite(v)) squares += (v - mean) * (v - mean);
  return {mean, std::sqrt(squares / static_cast<double>(n_known))};
}

double without_noise(double spread, double noise) {
  return std::sqrt(std::max(0.0, spread * spread - noise * noise));
}

}  // namespace

std::optional<PixelMapEstimate> pixel_offsets(const std::vector<GrayImage>& dark) {
  if (dark.size() < 2) return std::nullopt;
  const Means means = averaged(
      dark[0].width, dark[0].height, dark.size(),
      [&](std::size_t k, std::size_t i) { return static_cast<double>(dark[k][i]); },
      [](double v, double level, double all) { return v - level + all; });
  PixelMapEstimate out{.map = ImageF(dark[0].width, dark[0].height), .n_images = dark.size()};
  std::size_t n_known = 0;
  const auto [mean, spread] = spread_of(means.mean, n_known);
  for (std::size_t i = 0; i < out.map.size(); ++i)
    out.map.data[i] = static_cast<float>(means.mean.data[i] - mean);
  out.noise = std::hypot(std::sqrt(means.variance_of_mean), rounding_that_stays_dn(means.variance));
  out.rms = without_noise(spread, out.noise);
  return out;
}

std::optional<PixelMapEstimate> pixel_factors(const std::vector<GrayImage>& flat, const FlatLight& light) {
  if (flat.size() < 2) return std::nullopt;
  const int width = flat[0].width, height = flat[0].height;
  const ImageD field = light_of(light.field, width, height);
  const auto value = [&](std::size_t k, std::size_t i) {
    const auto dn = static_cast<double>(flat[k][i]);
    if (dn >= light.saturation_dn || dn <= 0.0) return std::numeric_limits<double>::quiet_NaN();
    const double offset_dn = light.offsets ? static_cast<double>(light.offsets->map.data[i]) : 0.0;
    return light.response.inverse(dn - light.black_level_dn - offset_dn) / field.data[i];
  };
  Means means = averaged(width, height, flat.size(), value,
                         [](double v, double level, double all) { return v * all / level; });
  for (double& v : means.mean.data)
    if (!(v > 0.0)) v = std::numeric_limits<double>::quiet_NaN();
  std::size_t n_known = 0;
  const double over_field = spread_of(means.mean, n_known).first;  // not 1 where the response bends the field
  if (n_known == 0) return std::nullopt;
  divide_by_what_is_around(means.mean);
  PixelMapEstimate out{.map = ImageF(width, height, 1.0F), .n_images = flat.size()};
  const auto [mean, spread] = spread_of(means.mean, n_known);
  out.n_unknown = out.map.size() - n_known;
  for (std::size_t i = 0; i < out.map.size(); ++i)
    if (std::isfinite(means.mean.data[i])) out.map.data[i] = static_cast<float>(means.mean.data[i] / mean);
  // An offset that is not well known is a factor that is not, by what it is of the light.
  const double field_dn = light.field.level_dn.value, light_dn = over_field * field_dn,
               of_offsets_dn = light.offsets ? light.offsets->noise : 0.0,
               rounding_dn = rounding_that_stays_dn(means.variance * field_dn * field_dn);
  out.noise = std::hypot(std::sqrt(means.variance_of_mean) / over_field, of_offsets_dn / light_dn,
                         rounding_dn / light_dn);
  out.rms = without_noise(spread / mean, out.noise);
  return out;
}

std::string pixel_map_file(const std::string& key, const std::string& camera) {
  return key + "_" + camera + ".exr";
}

}  // namespace fringetwin::calib
