// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/mask_areas.hpp"

#include <algorithm>

namespace fringetwin::compare {
namespace {

/// Writes the largest of each pixel and its neighbours along the row.
void widen_row(const unsigned char* in, int width, int radius_px, unsigned char* out) {
  for (int d = -radius_px; d <= radius_px; ++d) {
    const int first = std::max(0, -d), last = std::min(width, width - d);
    for (int x = first; x < last; ++x) out[x] = std::max(out[x], in[x + d]);
  }
}

ImageU8 inverted(const ImageU8& mask) {
  ImageU8 out = mask;
  for (unsigned char& v : out.data) v = v != 0 ? 0 : 1;
  return out;
}

/// Appends the pixel's neighbours that are still set, and clears them.
void take_neighbours(ImageU8& left, std::size_t at, std::vector<std::size_t>& found) {
  const auto width = static_cast<std::size_t>(left.width);
  const int x = static_cast<int>(at % width), y = static_cast<int>(at / width);
  for (int j = std::max(0, y - 1); j <= std::min(left.height - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(left.width - 1, x + 1); ++i) {
      if (left(i, j) == 0) continue;
      left(i, j) = 0;
      found.push_back(left.index(i, j));
    }
}

}  // namespace

ImageU8 dilated(const ImageU8& mask, int radius_px) {
  const int width = mask.width, height = mask.height;
  ImageU8 across(width, height, 0), out(width, height, 0);
#pragma omp parallel for schedule(static)
  for (int y = 0; y < height; ++y)
    widen_row(mask.data.data() + mask.index(0, y), width, radius_px, across.data.data() + across.index(0, y));
#pragma omp parallel for schedule(static)
  for (int y = 0; y < height; ++y) {
    unsigned char* to = out.data.data() + out.index(0, y);
    for (int from = std::max(0, y - radius_px); from <= std::min(height - 1, y + radius_px); ++from) {
      const unsigned char* row = across.data.data() + across.index(0, from);
      for (int x = 0; x < width; ++x) to[x] = std::max(to[x], row[x]);
    }
  }
  return out;
}

ImageU8 eroded(const ImageU8& mask, int radius_px) { return inverted(dilated(inverted(mask), radius_px)); }

ImageU8 closed(const ImageU8& mask, int radius_px) { return eroded(dilated(mask, radius_px), radius_px); }

ImageU8 edge(const ImageU8& mask) { return without(dilated(mask, 1), eroded(mask, 1)); }

ImageU8 without(ImageU8 mask, const ImageU8& other) {
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (other.data[i] != 0) mask.data[i] = 0;
  return mask;
}

ImageU8 either(const ImageU8& a, const ImageU8& b) {
  ImageU8 out = a;
  for (std::size_t i = 0; i < out.size(); ++i) out.data[i] = std::max(out.data[i], b.data[i]);
  return out;
}

std::vector<std::vector<std::size_t>> all_areas(const ImageU8& mask) {
  std::vector<std::vector<std::size_t>> areas;
  ImageU8 left = mask;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left.data[i] == 0) continue;
    left.data[i] = 0;
    std::vector<std::size_t> area{i};
    for (std::size_t next = 0; next < area.size(); ++next) take_neighbours(left, area[next], area);
    areas.push_back(std::move(area));
  }
  return areas;
}

std::vector<std::size_t> largest_area(const ImageU8& mask) {
  std::vector<std::vector<std::size_t>> areas = all_areas(mask);
  const auto largest = std::ranges::max_element(areas, {}, [](const auto& area) { return area.size(); });
  return largest == areas.end() ? std::vector<std::size_t>{} : std::move(*largest);
}

}  // namespace fringetwin::compare
