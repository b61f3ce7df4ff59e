// SPDX-License-Identifier: Apache-2.0
// Divides the surfaces of a scene into cells: places that lie in one cube of a grid and whose normals face
// the same of six sides. The shaders find a cell by the same keys and table (shaders/cells.glsl).
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fringetwin::render {

/// A grid of CELLS_PER_AXIS cubes along each axis.
struct CellGrid {
  Eigen::Vector3f corner_mm = Eigen::Vector3f::Zero();  ///< camera frame
  float per_mm = 0.0F;
  /// Returns the key of the cell of a place with its unit normal; 0 beyond the grid.
  std::uint32_t key(const Eigen::Vector3f& place_mm, const Eigen::Vector3f& normal) const;
};

/// Returns a grid whose cubes are the n-th part of the longest side of the box of these places, around its
/// middle; per_mm is 0 where they are no more than one place.
CellGrid grid_around(const std::vector<Eigen::Vector3f>& places_mm, int n);

/// Numbers the keys of cells in the order of their first occurrence.
class CellTable {
 public:
  CellTable();
  /// Returns the number of a key, -1 where it has none. Keys are not 0.
  std::int32_t find(std::uint32_t key) const;
  std::int32_t find_or_add(std::uint32_t key);
  std::size_t size() const { return n_; }
  /// Returns the entries as the shaders read them: key (0: none) and number, one after the other.
  const std::vector<std::uint32_t>& entries() const { return entries_; }
  /// Returns the number of entries less one; they are a power of two.
  std::uint32_t mask() const { return mask_; }

 private:
  bool put(std::uint32_t key, std::uint32_t number);
  void grow();

  std::vector<std::uint32_t> entries_;
  std::uint32_t mask_ = 0;
  std::size_t n_ = 0;
};

}  // namespace fringetwin::render
