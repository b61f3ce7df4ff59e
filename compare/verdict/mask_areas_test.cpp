// SPDX-License-Identifier: Apache-2.0
// Areas of small masks, counted by hand.
#include "compare/verdict/mask_areas.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace fringetwin::compare::mask_areas_test {
namespace {

/// A mask of this size with a filled rectangle, both corners included.
ImageU8 rectangle(int width, int height, int x0, int y0, int x1, int y1) {
  ImageU8 mask(width, height, 0);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) mask(x, y) = 1;
  return mask;
}
long set_pixels(const ImageU8& mask) { return std::count(mask.data.begin(), mask.data.end(), 1); }

TEST(MaskAreas, AnAreaIsWidenedAndNarrowedOnAllSides) {
  const ImageU8 mask = rectangle(20, 16, 6, 5, 10, 8);
  EXPECT_EQ(dilated(mask, 2).data, rectangle(20, 16, 4, 3, 12, 10).data);
  EXPECT_EQ(eroded(mask, 1).data, rectangle(20, 16, 7, 6, 9, 7).data);
  EXPECT_EQ(set_pixels(eroded(mask, 2)), 0);
}

TEST(MaskAreas, TheEdgeOfTheImageWearsNothingAway) {
  const ImageU8 all = rectangle(9, 7, 0, 0, 8, 6);
  EXPECT_EQ(eroded(all, 2).data, all.data);
  EXPECT_EQ(set_pixels(edge(all)), 0);
  EXPECT_EQ(eroded(rectangle(9, 7, 0, 0, 4, 6), 2).data, rectangle(9, 7, 0, 0, 2, 6).data);
}

TEST(MaskAreas, GapsAreClosedAndOutlinesStay) {
  const ImageU8 whole = rectangle(30, 24, 5, 5, 24, 18);
  ImageU8 speckled = whole;
  for (int x = 8; x < 22; x += 3) speckled(x, 10) = 0;
  EXPECT_EQ(closed(speckled, 2).data, whole.data);
  // 20 x 14 px less 18 x 12 inside, and 22 x 16 less 20 x 14 outside
  EXPECT_EQ(set_pixels(edge(whole)), (20 * 14 - 18 * 12) + (22 * 16 - 20 * 14));
}

TEST(MaskAreas, TheLargestAreaIsFoundAcrossCorners) {
  ImageU8 mask = either(rectangle(20, 20, 1, 1, 3, 3), rectangle(20, 20, 4, 4, 6, 5));
  mask(15, 15) = mask(16, 15) = 1;
  const std::vector<std::size_t> area = largest_area(mask);
  EXPECT_EQ(area.size(), 9u + 6u);
  EXPECT_EQ(*std::min_element(area.begin(), area.end()), mask.index(1, 1));
  EXPECT_EQ(*std::max_element(area.begin(), area.end()), mask.index(6, 5));
  EXPECT_TRUE(largest_area(ImageU8(4, 4, 0)).empty());
}

}  // namespace
}  // namespace fringetwin::compare::mask_areas_test
