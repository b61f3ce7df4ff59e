// SPDX-License-Identifier: Apache-2.0
// Lets light go from cell to cell until nothing is left of it, or so many times.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fringetwin::render {

/// What each cell gets of the light of others: rows of a sparse matrix.
class CellTransfer {
 public:
  struct Share {
    std::int32_t cell;
    float share;  ///< of that cell's irradiance, its reflectivity included
  };
  /// Adds the shares of the next cell; several of the same cell are added up.
  void add_row(std::vector<Share> shares);
  std::size_t rows() const { return first_.size() - 1; }

  /// Returns the light that cells have after it went on: b + T b + T T b ..., with `times` applications of T;
  /// none: until what is added falls below 1e-6 of the largest value. `b`: [cell][channel], rows() cells.
  std::vector<float> spread(const std::vector<float>& b, std::size_t channels,
                            std::optional<int> times) const;

 private:
  std::vector<float> apply(const std::vector<float>& x, std::size_t channels) const;

  std::vector<std::size_t> first_ = {0};
  std::vector<Share> shares_;
};

}  // namespace fringetwin::render
