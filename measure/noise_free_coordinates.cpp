// SPDX-License-Identifier: Apache-2.0
#include "measure/noise_free_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "twin/base/progress.hpp"

namespace fringetwin::measure {
namespace {

/// Interpolation, order repair and the match of a second camera look this far around a pixel, or less.
constexpr int kMarginPx = 8;

/// A part of an image: columns x0...x1-1 and rows y0...y1-1.
struct PixelBox {
  int x0 = std::numeric_limits<int>::max(), y0 = x0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool holds(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  void add(int x, int y) {
    x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
    y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
  }
};

/// Returns the box with a margin around it, as far as the image reaches. An empty one stays empty.
PixelBox widened(const PixelBox& box, int margin_px, int width, int height) {
  if (box.empty()) return box;
  PixelBox out;
  out.x0 = std::max(0, box.x0 - margin_px), out.x1 = std::min(width, box.x1 + margin_px);
  out.y0 = std::max(0, box.y0 - margin_px), out.y1 = std::min(height, box.y1 + margin_px);
  return out;
}

PixelBox box_of(const PointCloud& cloud, const std::vector<ObjectFit>& fits) {
  PixelBox box;
  for (const ObjectFit& fit : fits)
    for (const std::size_t i : fit.index)
      box.add(static_cast<int>(std::lround(cloud.q_cam_px[i].x())),
              static_cast<int>(std::lround(cloud.q_cam_px[i].y())));
  return box;
}

/// Returns where `other` sees coordinates that the box of `decode` has.
PixelBox box_in_other_camera(const CameraDecode& decode, const PixelBox& box, const CameraDecode& other) {
  struct Range {
    const ImageD* coordinate_px;
    double least, most;
  };
  std::vector<Range> ranges;
  for (const DirectionDecode& d : decode.directions) {
    const DirectionDecode* same = other.direction(d.axis);
    if (!same || same->coordinate_px.empty()) continue;
    Range range{&same->coordinate_px, std::numeric_limits<double>::infinity(),
                -std::numeric_limits<double>::infinity()};
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x)
        if (const double c = d.coordinate_px(x, y); std::isfinite(c))
          range.least = std::min(range.least, c), range.most = std::max(range.most, c);
    ranges.push_back(range);
  }
  PixelBox out;
  for (int y = 0; y < other.height(); ++y)
    for (int x = 0; x < other.width(); ++x) {
      const auto is_inside = [x, y](const Range& r) {
        const double c = (*r.coordinate_px)(x, y);
        return c >= r.least && c <= r.most;
      };
      if (!ranges.empty() && std::ranges::all_of(ranges, is_inside)) out.add(x, y);
    }
  return out;
}

template <class AnyImage>
ImageF crop(const AnyImage& image, const PixelBox& box) {
  ImageF out(box.width(), box.height());
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) out(x, y) = image(box.x0 + x, box.y0 + y);
  return out;
}

CameraImages crop(const CameraImages& from, const PixelBox& box) {
  CameraImages out{.camera = from.camera,
                   .bit_depth = from.bit_depth,
                   .radiance = from.radiance,
                   .gray_code_exposure = from.gray_code_exposure,
                   .clip = from.clip};
  for (const GrayImage& image : from.images) out.images.push_back(crop(image, box));
  if (from.white) out.white = crop(*from.white, box);
  if (from.black) out.black = crop(*from.black, box);
  return out;
}

/// Puts the coordinates of a decode of the box in the place of those that there are; leaves none outside it.
void replace_coordinates(const CameraDecode& of_box, const PixelBox& box, CameraDecode& decode) {
  for (DirectionDecode& d : decode.directions) {
    const ImageD& from = of_box.direction(d.axis)->coordinate_px;
    for (int y = 0; y < d.coordinate_px.height; ++y)
      for (int x = 0; x < d.coordinate_px.width; ++x) {
        double& coordinate_px = d.coordinate_px(x, y);
        if (!std::isfinite(coordinate_px)) continue;
        coordinate_px = box.holds(x, y) ? from(x - box.x0, y - box.y0) : std::nan("");
      }
  }
}

/// Decodes the box alone, with the light that the whole image tells: a small object does not tell it.
CameraDecode decode_box(const CameraImages& images, const Fringes& fringes, const DecodeOptions& options,
                        const PixelBox& box) {
  CameraImages part = crop(images, box);
  DecodeOptions of_part = options;
  of_part.light.reset();
  of_part.variance_offset_dn2 = of_part.variance_per_dn = 0.0;  // nothing to estimate
  if (!options.light) return decode(part, fringes, of_part);
  const std::optional<LightFactors> light = estimate_light(images, fringes, *options.light);
  if (light && light->differ())
    part = with_steady_light(std::move(part), *light, options.light->black_level_dn);
  return decode(part, fringes, of_part);
}

}  // namespace

void take_noise_free_coordinates(const Fringes& fringes, const std::vector<CameraImages>& noise_free,
                                 const std::vector<DecodeOptions>& options, const PointCloud& cloud,
                                 const std::vector<ObjectFit>& fits, double smoothing_px,
                                 std::vector<CameraDecode>& decodes) {
  const int margin_px = kMarginPx + static_cast<int>(std::ceil(smoothing_px));
  std::vector<PixelBox> boxes;
  for (std::size_t i = 0; i < decodes.size(); ++i) {
    const PixelBox box = i == 0 ? box_of(cloud, fits) : box_in_other_camera(decodes[0], boxes[0], decodes[i]);
    boxes.push_back(widened(box, margin_px, decodes[i].width(), decodes[i].height()));
  }
  for (std::size_t i = 0; i < decodes.size(); ++i) {
    throw_if_cancelled();
    if (boxes[i].empty()) {
      for (DirectionDecode& d : decodes[i].directions) std::ranges::fill(d.coordinate_px.data, std::nan(""));
      continue;
    }
    replace_coordinates(decode_box(noise_free[i], fringes, options[i], boxes[i]), boxes[i], decodes[i]);
  }
}

}  // namespace fringetwin::measure
