// SPDX-License-Identifier: Apache-2.0
// Divides the surfaces of a scene into cells: places that lie in one cube and whose normals face the same of
// six sides. Cubes are as large as in a grid of CELLS_PER_AXIS around its middle; around that one they are
// twice as large, and so on. The shaders find a cell by the same keys and table (shaders/cells.glsl).
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fringetwin::render {

struct CellGrid {
  Eigen::Vector3f middle_mm = Eigen::Vector3f::Zero();  ///< camera frame
  float per_mm = 0.0F;                                  ///< cubes, in the middle
  /// Returns the key of the cell of a place with its unit normal, `coarser` (0 or CELL_COARSER) levels above
  /// its own; 0 beyond the grid, hundreds of millions of cubes away.
  std::uint32_t key(const Eigen::Vector3f& place_mm, const Eigen::Vector3f& normal, int coarser = 0) const;
};

/// Returns a grid whose cubes are, in the middle of the box of these places, the n-th part of its longest
/// side; per_mm is 0 where they are no more than one place.
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
