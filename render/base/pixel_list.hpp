// SPDX-License-Identifier: Apache-2.0
// Lists of pixels as the kernels read them (shaders/work_items.glsl): a code for each pixel.
#pragma once
#include <cstddef>
#include <cstdint>

namespace fringetwin::render {

/// Images that are listed have fewer pixels a side.
constexpr int kListLimitPx = 1 << 15;
/// Texels that every device takes in one buffer.
constexpr std::size_t kLongestList = 65536;

/// Returns the code of a pixel in a list: x, y and whether its edges run along x rather than y.
inline std::uint32_t list_code(int x, int y, bool along_y = false) {
  return static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 15 | (along_y ? 1U << 31 : 0U);
}

/// Returns the code of the pixel at an index of an image (x + width y).
inline std::uint32_t list_code_at(std::size_t index, int width) {
  return list_code(static_cast<int>(index) % width, static_cast<int>(index) / width);
}

struct ListedPixel {
  int x, y;
};
inline ListedPixel listed_pixel(std::uint32_t code) {
  return {static_cast<int>(code & 0x7fffU), static_cast<int>((code >> 15) & 0x7fffU)};
}

}  // namespace fringetwin::render
