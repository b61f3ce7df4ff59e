// SPDX-License-Identifier: Apache-2.0
// Pixels around blocks against looking at every pixel's neighbourhood. No tolerances.
#include "render/trace/pixel_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "render/shaders/shared.h"

namespace fringetwin::render::pixel_blocks_test {
namespace {

using Mask = std::vector<unsigned char>;

Mask mask_of(const std::vector<PixelRun>& runs, int width, int height) {
  Mask mask(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  for (const PixelRun& run : runs) {
    EXPECT_TRUE(run.n_px > 0 && run.x_px >= 0 && run.x_px + run.n_px <= width && run.y_px >= 0 &&
                run.y_px < height);
    for (int k = 0; k < run.n_px; ++k) mask[static_cast<std::size_t>(run.y_px * width + run.x_px + k)] = 1;
  }
  return mask;
}

Mask around_by_neighbourhoods(const std::vector<std::uint32_t>& blocks, int width, int height, int reach) {
  const auto inside = [&](int x, int y) {
    return std::ranges::any_of(blocks, [&](std::uint32_t block) {
      const auto [x0, y0] = corner_of(block);
      return x >= x0 && x < x0 + BLOCK_WIDTH && y >= y0 && y < y0 + BLOCK_HEIGHT;
    });
  };
  Mask mask;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      bool near = false;
      for (int j = std::max(0, y - reach); j <= std::min(height - 1, y + reach); ++j)
        for (int i = std::max(0, x - reach); i <= std::min(width - 1, x + reach); ++i)
          near = near || inside(i, j);
      mask.push_back(near && !inside(x, y));
    }
  return mask;
}

// Images whose last blocks are cut off by the border, and blocks drawn from none to all.
TEST(PixelsAround, AreThoseThatANeighbourhoodReaches) {
  std::mt19937 random(1);
  for (const auto& [width, height] : {std::pair{160, 48}, std::pair{150, 43}, std::pair{33, 9}}) {
    const int n_x = (width + BLOCK_WIDTH - 1) / BLOCK_WIDTH, n_y = (height + BLOCK_HEIGHT - 1) / BLOCK_HEIGHT;
    for (const double share : {0.0, 0.1, 0.3, 0.7, 1.0})
      for (const int reach : {1, 2, BLOCK_HEIGHT / 2}) {
        std::bernoulli_distribution drawn(share);
        std::vector<std::uint32_t> blocks;
        for (int y = 0; y < n_y; ++y)
          for (int x = 0; x < n_x; ++x)
            if (drawn(random))
              blocks.push_back(static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16);
        EXPECT_EQ(mask_of(pixels_around(blocks, width, height, reach), width, height),
                  around_by_neighbourhoods(blocks, width, height, reach))
            << width << " x " << height << ", " << blocks.size() << " blocks, reach " << reach;
      }
  }
}

}  // namespace
}  // namespace fringetwin::render::pixel_blocks_test
