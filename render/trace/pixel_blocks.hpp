// SPDX-License-Identifier: Apache-2.0
// Divides the image into blocks of BLOCK_WIDTH x BLOCK_HEIGHT pixels, one work group of the shaders each, and
// finds those that have to be traced.
#pragma once
#include <cstdint>
#include <vector>

#include "render/scene/scene.hpp"
#include "render/trace/lens_table.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the blocks that may see an object, row by row, as x | y << 16 in blocks.
std::vector<std::uint32_t> active_blocks(const Camera& camera, const PackedScene& scene,
                                         const LensTable& lens);

/// The top left pixel of a block.
struct BlockCorner {
  int x_px, y_px;
};
inline BlockCorner corner_of(std::uint32_t block) {
  return {static_cast<int>(block & 0xffffU) * BLOCK_WIDTH, static_cast<int>(block >> 16) * BLOCK_HEIGHT};
}

/// A row of pixels, or a part of one.
struct PixelRun {
  int x_px, y_px, n_px;
};
/// Returns the pixels of the image that lie within `reach_px` of one of these blocks (along both axes) and in
/// none of them, in runs. `reach_px`: at most half of BLOCK_HEIGHT. The blocks: row by row, as
/// active_blocks() returns them.
std::vector<PixelRun> pixels_around(const std::vector<std::uint32_t>& blocks, int width_px, int height_px,
                                    int reach_px);

}  // namespace fringetwin::render
