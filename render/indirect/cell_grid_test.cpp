// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/cell_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
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

TEST(CellGrid, HasLargerCubesFartherAway) {
  const CellGrid grid = grid_around({{0, 0, 100}, {48, 10, 110}}, 48);
  const Vector3f n(0, 0, 1), middle(24, 5, 105);
  const float half = 0.5F * CELLS_PER_AXIS;
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {1.0F, -1.0F}) {
      const Vector3f d = sign * Vector3f::Unit(axis);
      float side = 1.0F;
      for (float from = 0.0F; from < 8.0F * half; from = std::max(half, 2.0F * from), side *= 2.0F) {
        // two places in one cube, and one in the next
        const Vector3f first = middle + (from + 0.25F * side) * d;
        EXPECT_EQ(grid.key(first + 0.5F * side * d, n), grid.key(first, n)) << axis << ' ' << from;
        EXPECT_NE(grid.key(first + side * d, n), grid.key(first, n)) << axis << ' ' << from;
        if (from == 0.0F) continue;
        EXPECT_NE(grid.key(middle + (from - 0.25F * side) * d, n), grid.key(first, n)) << axis << ' ' << from;
      }
    }
  EXPECT_NE(grid.key(middle + Vector3f(1e8F, 0, 0), n), 0U);
  EXPECT_EQ(grid.key(middle + Vector3f(1e12F, 0, 0), n), 0U);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_EQ(grid.key(middle + std::numeric_limits<float>::quiet_NaN() * Vector3f::Unit(axis), n), 0U);
  EXPECT_EQ(grid_around({}, 48).per_mm, 0.0F);
  EXPECT_EQ(grid_around({{1, 2, 3}, {1, 2, 3}}, 48).per_mm, 0.0F);
}

TEST(CellGrid, HasCoarserCellsAroundItsFineOnes) {
  const CellGrid grid = grid_around({{0, 0, 100}, {48, 10, 110}}, 48);
  const Vector3f n(0, 0, 1);
  std::mt19937 random(7);
  std::map<std::uint32_t, std::uint32_t> coarse_of;
  std::set<std::uint32_t> fine, coarse;
  for (int i = 0; i < 50000; ++i) {
    Vector3f p(24, 5, 105);
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += std::uniform_real_distribution<float>(-200.0F, 200.0F)(random);
    p.z() = 100.0F;
    const std::uint32_t key = grid.key(p, n), around = grid.key(p, n, CELL_COARSER);
    EXPECT_EQ(coarse_of.try_emplace(key, around).first->second, around);  // one for all places of a cell
    fine.insert(key);
    coarse.insert(around);
  }
  for (const std::uint32_t key : coarse) EXPECT_FALSE(fine.contains(key));
  EXPECT_LT(8 * coarse.size(), fine.size());  // 16 times as many, as far as they were met
}

TEST(CellTable, NumbersKeysInTheirOrderAndFindsThemAgain) {
  CellTable table;
  std::mt19937 random(3);
  std::vector<std::uint32_t> keys;
  std::set<std::uint32_t> known;
  while (keys.size() < 20000) {
    const auto key = static_cast<std::uint32_t>(1 + random() % (24UL << 24));
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
