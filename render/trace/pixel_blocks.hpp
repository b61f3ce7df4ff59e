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

}  // namespace fringetwin::render
