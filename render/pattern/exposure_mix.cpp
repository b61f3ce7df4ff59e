// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/exposure_mix.hpp"

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

/// Adds the patterns to a row, each with a weight; none where the weight is 0.
void add_to_row(const SeenPatterns& patterns, const std::array<double, 3>& weights, int y, ImageF& out) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (weights[k] == 0.0) continue;
    const auto weight = static_cast<float>(weights[k]);
    for (int x = 0; x < out.width; ++x) out(x, y) += weight * (*patterns[k])(x, y);
  }
}

/// Returns what the exposure of a row sees, the shares times the factor of its exposure.
ExposureParts parts_of_row(const Camera& camera, std::size_t image, const RowHeights& heights, int y) {
  const ExposureTiming& timing = *camera.timing;
  ExposureParts parts = exposure_parts(timing.begin(image, heights.of(y)), timing.exposure);
  for (double& share : parts.share) share *= factor_of(camera.exposure_factors, image);
  return parts;
}

}  // namespace

ImageRange with_neighbours(ImageRange range, std::size_t n_images) {
  const std::size_t first = range.first > 0 ? range.first - 1 : 0,
                    end = std::min(n_images, range.first + range.count + 1);
  return {first, end - first};
}

SeenPatterns seen_patterns(std::span<const ImageF> images, ImageRange range, std::size_t image) {
  FT_CHECK(image >= range.first && image < range.first + range.count && images.size() >= range.count,
           "an image of the range");
  const std::size_t at = image - range.first;
  return {&images[at > 0 ? at - 1 : at], &images[at], &images[std::min(at + 1, range.count - 1)]};
}

bool mixes_patterns(const Camera& camera, ImageRange range) {
  if (!camera.timing) return false;
  for (std::size_t k = range.first; k < range.first + range.count; ++k)
    if (sees_neighbours(*camera.timing, k)) return true;
  return false;
}

ImageF exposed(const Camera& camera, std::size_t image, const SeenPatterns& patterns) {
  const RowHeights heights = camera.row_heights();
  ImageF out(patterns[1]->width, patterns[1]->height, 0.0F);
#pragma omp parallel for
  for (int y = 0; y < out.height; ++y)
    add_to_row(patterns, parts_of_row(camera, image, heights, y).share, y, out);
  return out;
}

ExposureTimes exposure_times(const ExposureTiming& timing, std::size_t image) {
  const double rows = timing.read_out, row = timing.exposure;
  return {.middle = timing.middle(image),
          .apart = std::max(0.5 * rows, std::sqrt((rows * rows + row * row) / 12.0))};
}

ImageF exposed_moving(const Camera& camera, std::size_t image, const SeenPatterns& earlier,
                      const SeenPatterns& later) {
  const ExposureTiming& timing = *camera.timing;
  const ExposureTimes times = exposure_times(timing, image);
  const double middle = timing.late_of(image) + 0.5 * timing.exposure;  // after the begin of the pattern
  const RowHeights heights = camera.row_heights();
  ImageF out(earlier[1]->width, earlier[1]->height, 0.0F);
#pragma omp parallel for
  for (int y = 0; y < out.height; ++y) {
    const ExposureParts parts = parts_of_row(camera, image, heights, y);
    std::array<double, 3> early{}, late{};
    for (std::size_t k = 0; k < 3; ++k) {
      late[k] = parts.share[k] * (0.5 + 0.5 * (parts.middle[k] - middle) / times.apart);
      early[k] = parts.share[k] - late[k];
    }
    add_to_row(earlier, early, y, out);
    add_to_row(later, late, y, out);
    for (int x = 0; x < out.width; ++x) out(x, y) = std::max(0.0F, out(x, y));
  }
  return out;
}

}  // namespace fringetwin::render
