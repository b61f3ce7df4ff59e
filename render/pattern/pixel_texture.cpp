// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/pixel_texture.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace fringetwin::render {
namespace {

/// Returns the product of the slopes along one axis. `reach`: pixels to the nearer border.
template <class AnyImage>
double moment_along(const ImageF& factor, const AnyImage& image, std::size_t i, std::size_t distance,
                    int reach) {
  const auto tells = [&](std::size_t k) { return factor[k] > 0.0F && image[k] > 0.0F; };
  if (reach < 1 || !tells(i) || !tells(i - distance) || !tells(i + distance)) return 0.0;
  const bool is_wide = reach > 1 && tells(i - 2 * distance) && tells(i + 2 * distance);
  return slope_along(factor, i, distance, is_wide) * slope_along(image, i, distance, is_wide);
}

}  // namespace

template <class AnyImage>
double slope_along(const AnyImage& image, std::size_t i, std::size_t distance, bool is_wide) {
  const auto difference = [&](std::size_t far) {
    return static_cast<double>(image[i + far]) - static_cast<double>(image[i - far]);
  };
  return is_wide ? (8.0 * difference(distance) - difference(2 * distance)) / 12.0
                 : 0.5 * difference(distance);
}

template <class AnyImage>
double texture_moment(const ImageF& factor, const AnyImage& image, int x, int y) {
  const std::size_t i = image.index(x, y);
  return moment_along(factor, image, i, 1, std::min(x, image.width - 1 - x)) +
         moment_along(factor, image, i, static_cast<std::size_t>(image.width),
                      std::min(y, image.height - 1 - y));
}
template double slope_along(const ImageF&, std::size_t, std::size_t, bool);
template double slope_along(const GrayImage&, std::size_t, std::size_t, bool);
template double texture_moment(const ImageF&, const ImageF&, int, int);
template double texture_moment(const ImageF&, const GrayImage&, int, int);

void apply_pixel_texture(const PixelTexture& texture, double spread_px, double exposure, ImageF& image) {
  if (spread_px == 0.0 || texture.factor.empty()) {
    for (std::size_t i = 0; i < image.size(); ++i) image.data[i] = texture.of(image.data[i], i, exposure);
    return;
  }
  ImageF out(image.width, image.height);
#pragma omp parallel for schedule(static)
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t i = image.index(x, y);
      const double plain = texture.factor_at(i) * static_cast<double>(image.data[i]);
      const double moved = plain + spread_px * spread_px * texture_moment(texture.factor, image, x, y);
      out.data[i] =
          static_cast<float>(std::max(std::min(0.0, plain), moved) + exposure * texture.offset_at(i));
    }
  image = std::move(out);
}

}  // namespace fringetwin::render
