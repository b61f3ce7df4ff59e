// SPDX-License-Identifier: Apache-2.0
#include "measure/description/tiles.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fringetwin::measure {
namespace {

constexpr int kSide = 48;       ///< px: some fringes and some periods of the code in each tile
constexpr int kMostAcross = 3;  ///< tiles: 3 x 3 hold 20,000 pixels
constexpr int kGap = 3;         ///< px: as far as the repair of orders looks
constexpr int kStride = 2;      ///< px: of the pixels that are counted to choose the tiles

/// Returns whether the fringes reach pixel i.
bool reached(const CameraImages& images, std::size_t i, double min_modulation_dn) {
  float low = images.images.front()[i], high = low;
  for (const GrayImage& image : images.images) {
    low = std::min(low, image[i]);
    high = std::max(high, image[i]);
  }
  return static_cast<double>(high - low) >= 2.0 * min_modulation_dn &&
         static_cast<double>(high) < images.saturation_dn();
}

}  // namespace

Tiles::Tiles(const CameraImages& images, double min_modulation_dn) {
  const GrayImage& first = images.images.front();
  struct Counted {
    Corner corner;
    int n = 0;
  };
  std::vector<Counted> all;
  for (int y = 0; y + kSide <= first.height; y += kSide)
    for (int x = 0; x + kSide <= first.width; x += kSide) all.push_back({{x, y}, 0});
#pragma omp parallel for schedule(dynamic)
  for (std::size_t t = 0; t < all.size(); ++t)
    for (int y = 0; y < kSide; y += kStride)
      for (int x = 0; x < kSide; x += kStride)
        all[t].n +=
            reached(images, first.index(all[t].corner.x + x, all[t].corner.y + y), min_modulation_dn) ? 1 : 0;
  const auto best =
      std::ranges::max_element(all, [](const Counted& a, const Counted& b) { return a.n < b.n; });
  if (best == all.end() || best->n == 0) return;
  const int enough = best->n / 2;
  std::erase_if(all, [enough](const Counted& c) { return c.n < enough || c.n == 0; });
  // spread over what is left
  constexpr std::size_t kMost = kMostAcross * kMostAcross;
  const std::size_t count = std::min(all.size(), kMost);
  for (std::size_t k = 0; k < count; ++k) corners_.push_back(all[k * all.size() / count].corner);
}

Tiles Tiles::only(std::size_t k) const {
  Tiles one;
  one.corners_ = {corners_.at(k)};
  return one;
}

template <class T, class AnyImage>
Image<T> Tiles::cut_from(const AnyImage& image, T gap) const {
  const int across = std::min(kMostAcross, static_cast<int>(corners_.size()));
  const int down = (static_cast<int>(corners_.size()) + across - 1) / across;
  constexpr int kPitch = kSide + kGap;
  Image<T> out(across * kPitch, down * kPitch, gap);
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const int x0 = static_cast<int>(k) % across * kPitch, y0 = static_cast<int>(k) / across * kPitch;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) out(x0 + x, y0 + y) = image(corners_[k].x + x, corners_[k].y + y);
  }
  return out;
}

ImageF Tiles::cut(const ImageF& image, float gap) const { return cut_from<float>(image, gap); }
ImageD Tiles::cut(const ImageD& image, double gap) const { return cut_from<double>(image, gap); }

CameraImages Tiles::cut(const CameraImages& images) const {
  CameraImages out{.camera = images.camera,
                   .bit_depth = images.bit_depth,
                   .radiance = images.radiance,
                   .gray_code_exposure = images.gray_code_exposure};
  for (const GrayImage& image : images.images) out.images.push_back(cut_from<float>(image, 0.0f));
  if (images.white) out.white = cut_from<float>(*images.white, 0.0f);
  if (images.black) out.black = cut_from<float>(*images.black, 0.0f);
  return out;
}

ImageU8 reached_pixels(const CameraImages& images, double min_modulation_dn) {
  ImageU8 out(images.images.front().width, images.images.front().height);
  for (std::size_t i = 0; i < out.size(); ++i) out.data[i] = reached(images, i, min_modulation_dn) ? 1 : 0;
  return out;
}

}  // namespace fringetwin::measure
