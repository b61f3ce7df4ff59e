// SPDX-License-Identifier: Apache-2.0
// Tells in which order the corners of one picture of the board run beside those of another: a board that
// looks the same turned by 180 degrees is read from its other end by a camera that stands upside down.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/board/observations.hpp"

namespace fringetwin::calib {

/// A way in which corners can be read from another end of the board, or as in a mirror.
struct CornerOrder {
  const char* what;  ///< continues a sentence about the corners
  bool flip_rows, flip_columns, transpose;
  bool is_mirrored() const { return (flip_rows != flip_columns) != transpose; }
};

/// All orders but the right one. Those that exchange rows and columns are possible on a board with as many of
/// both.
inline constexpr CornerOrder kCornerOrders[] = {
    {"run in the reverse order (the board turned by 180 degrees)", true, true, false},
    {"are mirrored left to right", false, true, false},
    {"are mirrored top to bottom", true, false, false},
    {"have rows and columns exchanged", false, false, true},
    {"are turned by 90 degrees", true, false, true},
    {"are turned by -90 degrees", false, true, true},
    {"have rows and columns exchanged and reversed", true, true, true},
};
inline constexpr const CornerOrder& kReverseOrder = kCornerOrders[0];

/// Returns the corners (or what was read at them) that were in this order in the right one.
template <class T>
std::vector<T> reordered(const Board& board, const std::vector<T>& corners, const CornerOrder& order) {
  std::vector<T> out(corners.size());
  for (int row = 0; row < board.height_n; ++row)
    for (int col = 0; col < board.width_n; ++col) {
      const int r = order.flip_rows ? board.height_n - 1 - row : row;
      const int c = order.flip_columns ? board.width_n - 1 - col : col;
      const int from = order.transpose ? c * board.width_n + r : r * board.width_n + c;
      out[row * board.width_n + col] = corners[from];
    }
  return out;
}

/// Returns the share of the board's cells whose four corners run round the other way than rows to the right
/// and downwards do: about 0 for a board seen from its front, 1 for one seen in a mirror. NaN where fewer
/// than six cells are seen whole: a corner that was read badly is in four.
double mirrored_share(const Board& board, const std::vector<Corner>& corners);

/// Returns whether three quarters of the cells say that the board is seen in a mirror; nothing where too few
/// are seen.
std::optional<bool> is_mirrored(const Board& board, const std::vector<Corner>& corners);

/// Throws UserError(input) for a device most of whose views have the corners as in a mirror where another's
/// have not: they cannot be of one board. Where all devices have, rows are numbered from the bottom, which
/// fits together. A single such view has a sentence of its own (solve/seed.hpp).
void check_not_mirrored(const Observations& observations);

/// Returns the order in which `other` is read beside `first`, both of the same coordinates (the projector's
/// at each corner): the turn without a mirror that brings them together. nullptr where they agree as they
/// are, and where nothing brings them together.
const CornerOrder* turn_beside(const Board& board, const std::vector<Corner>& first,
                               const std::vector<Corner>& other);

}  // namespace fringetwin::calib
