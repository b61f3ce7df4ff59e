// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/cell_grid.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "render/shaders/shared.h"

namespace fringetwin::render {
namespace {

using Eigen::Vector3f;

TEST(CellGrid, PlacesOfOneCubeAndSideShareAKey) {
  const CellGrid grid = grid_around({{0, 0, 100}, {48, 10, 110}}, 48);  // cubes of 1 mm
  EXPECT_FLOAT_EQ(grid.per_mm, 1.0F);
  const Vector3f p(10.25F, 5.25F, 104.25F), up(0, 0, -1);
  const std::uint32_t key = grid.key(p, up);
  EXPECT_NE(key, 0U);
  EXPECT_EQ(grid.key(p + Vector3f(0.5F, 0.5F, 0.5F), Vector3f(0.5F, 0.5F, -0.7F).normalized()), key);
  std::set<std::uint32_t> others;
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {1.0F, -1.0F}) others.insert(grid.key(p, sign * Vector3f::Unit(axis)));
  for (int axis = 0; axis < 3; ++axis) others.insert(grid.key(p + Vector3f::Unit(axis), up));
  EXPECT_EQ(others.size(), 9U);  // six sides, `up` among them, and three neighbours
  EXPECT_TRUE(others.contains(key));
}

TEST(CellGrid, EndsSomewhere) {
  const CellGrid grid = grid_around({{0, 0, 100}, {48, 10, 110}}, 48);
  const Vector3f n(0, 0, 1), middle(24, 5, 105);
  const float half = 0.5F * CELLS_PER_AXIS;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NE(grid.key(middle + (half - 0.5F) * Vector3f::Unit(axis), n), 0U);
    EXPECT_EQ(grid.key(middle + (half + 0.5F) * Vector3f::Unit(axis), n), 0U);
    EXPECT_NE(grid.key(middle - (half - 0.5F) * Vector3f::Unit(axis), n), 0U);
    EXPECT_EQ(grid.key(middle - (half + 0.5F) * Vector3f::Unit(axis), n), 0U);
  }
  EXPECT_EQ(grid_around({}, 48).per_mm, 0.0F);
  EXPECT_EQ(grid_around({{1, 2, 3}, {1, 2, 3}}, 48).per_mm, 0.0F);
}

TEST(CellTable, NumbersKeysInTheirOrderAndFindsThemAgain) {
  CellTable table;
  std::mt19937 random(3);
  std::vector<std::uint32_t> keys;
  std::set<std::uint32_t> known;
  while (keys.size() < 20000) {
    const auto key = static_cast<std::uint32_t>(1 + random() % (6UL << 27));
    if (known.insert(key).second) keys.push_back(key);
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    EXPECT_EQ(table.find(keys[i]), -1);
    ASSERT_EQ(table.find_or_add(keys[i]), static_cast<int>(i));
  }
  for (std::size_t i = 0; i < keys.size(); ++i) ASSERT_EQ(table.find_or_add(keys[i]), static_cast<int>(i));
  EXPECT_EQ(table.size(), keys.size());
  EXPECT_EQ(table.entries().size(), 2 * (std::size_t{table.mask()} + 1));
  EXPECT_EQ(table.mask() & (table.mask() + 1), 0U);
}

TEST(CellTable, GrowsWhereManyKeysWantOnePlace) {
  CellTable table;
  std::vector<std::uint32_t> keys;  // of the same first entry in a table of 1024
  for (std::uint32_t key = 1; keys.size() < 3 * CELL_PROBES; ++key)
    if ((((key * CELL_HASH) >> CELL_HASH_SHIFT) & 1023U) == 17U) keys.push_back(key);
  for (const std::uint32_t key : keys) table.find_or_add(key);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_EQ(table.find(keys[i]), static_cast<int>(i));
  EXPECT_GT(table.mask(), 1023U);
}

}  // namespace
}  // namespace fringetwin::render
