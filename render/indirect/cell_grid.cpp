// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/cell_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "render/shaders/shared.h"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::uint32_t kFirstEntries = 1024;

std::uint32_t first_entry(std::uint32_t key) { return (key * CELL_HASH) >> CELL_HASH_SHIFT; }

// Returns which of six sides a normal faces: +x, -x, +y, -y, +z, -z.
std::uint32_t side_of(const Eigen::Vector3f& normal) {
  const Eigen::Vector3f a = normal.cwiseAbs();
  const bool x = a.x() >= std::max(a.y(), a.z()), y = !x && a.y() >= a.z();
  const float facing = x ? normal.x() : y ? normal.y() : normal.z();
  return (x ? 0U : y ? 2U : 4U) + (facing > 0.0F ? 0U : 1U);
}

}  // namespace

std::uint32_t CellGrid::key(const Eigen::Vector3f& place_mm, const Eigen::Vector3f& normal,
                            int coarser) const {
  constexpr auto kHalf = static_cast<float>(CELLS_PER_AXIS / 2);
  const Eigen::Array3f r = (place_mm - middle_mm).array() * per_mm;
  const float far = r.abs().maxCoeff<Eigen::PropagateNaN>() * (1.0F / kHalf);
  if (!(far < static_cast<float>(1 << (CELL_LEVELS - CELL_COARSER)))) return 0;
  const int level = std::bit_width(static_cast<std::uint32_t>(far)) + coarser;
  const Eigen::Array<std::uint32_t, 3, 1> u =
      ((r * std::ldexp(1.0F, -level)).floor() + kHalf).cast<std::uint32_t>();
  const std::uint32_t place = u[0] | u[1] << CELL_BITS | u[2] << (2 * CELL_BITS);
  return 1U + (place | side_of(normal) << (3 * CELL_BITS) |
               static_cast<std::uint32_t>(level) << (3 * CELL_BITS + 3));
}

CellGrid grid_around(const std::vector<Eigen::Vector3f>& places_mm, int n) {
  CellGrid grid;
  if (places_mm.empty()) return grid;
  Eigen::Vector3f least = places_mm.front(), most = least;
  for (const Eigen::Vector3f& p : places_mm) {
    least = least.cwiseMin(p);
    most = most.cwiseMax(p);
  }
  const float side_mm = (most - least).maxCoeff() / static_cast<float>(n);
  if (!(side_mm > 0.0F)) return grid;
  grid.per_mm = 1.0F / side_mm;
  grid.middle_mm = 0.5F * (least + most);
  return grid;
}

CellTable::CellTable() : entries_(2 * kFirstEntries, 0U), mask_(kFirstEntries - 1) {}

std::int32_t CellTable::find(std::uint32_t key) const {
  const std::uint32_t first = first_entry(key);
  for (std::uint32_t k = 0; k < CELL_PROBES; ++k) {
    const std::size_t entry = 2 * std::size_t{(first + k) & mask_};
    if (entries_[entry] == key) return static_cast<std::int32_t>(entries_[entry + 1]);
    if (entries_[entry] == 0) break;
  }
  return -1;
}

std::int32_t CellTable::find_or_add(std::uint32_t key) {
  FT_CHECK(key != 0, "a key of a cell");
  if (const std::int32_t found = find(key); found >= 0) return found;
  const auto number = static_cast<std::uint32_t>(n_++);
  while (2 * n_ > mask_ || !put(key, number)) grow();
  return static_cast<std::int32_t>(number);
}

// Returns false where the shaders would not find the key: too many others lie before it.
bool CellTable::put(std::uint32_t key, std::uint32_t number) {
  const std::uint32_t first = first_entry(key);
  for (std::uint32_t k = 0; k < CELL_PROBES; ++k) {
    const std::size_t entry = 2 * std::size_t{(first + k) & mask_};
    if (entries_[entry] != 0) continue;
    entries_[entry] = key;
    entries_[entry + 1] = number;
    return true;
  }
  return false;
}

void CellTable::grow() {
  const std::vector<std::uint32_t> before = std::move(entries_);
  bool all = false;
  while (!all) {
    mask_ = 2 * mask_ + 1;
    entries_.assign(2 * (std::size_t{mask_} + 1), 0U);
    all = true;
    for (std::size_t i = 0; all && i < before.size(); i += 2)
      if (before[i] != 0) all = put(before[i], before[i + 1]);
  }
}

}  // namespace fringetwin::render
