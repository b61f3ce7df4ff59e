// SPDX-License-Identifier: Apache-2.0
// Finds the corners of a board in a picture, with OpenCV's detectors.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

enum class BoardKind {
  chessboard,          ///< inner corners
  circles,             ///< centres of a regular grid
  asymmetric_circles,  ///< centres; every other row shifted by half a spacing
  charuco              ///< inner corners of a chessboard with ArUco markers; partial views
};
/// "chessboard", "circles", "asymmetric-circles", "charuco"; throws UserError(usage).
BoardKind board_kind(const std::string& name);

struct BoardPattern {
  BoardKind kind = BoardKind::chessboard;
  /// The board as the solve sees it. asymmetric_circles: the regular lattice that holds the pattern, so twice
  /// as many columns as circles in a row, spacing half of the distance between neighbours in a row; every
  /// other place is empty.
  Board board;
  std::string dictionary = "DICT_4X4_50";  ///< charuco
  double marker_to_square = 0.75;          ///< charuco: side of a marker / side of a square
};

/// One corner per place of the board, unseen ones marked; nullopt when the board is not found (charuco: fewer
/// than 6 corners). Refined to sub-pixel. A chessboard or circle grid that looks the same upside down is read
/// with its rows running to the right in the picture, another chessboard from where the square inside the
/// first corner is dark. Values of `image` in DN; NaN counts as dark.
std::optional<std::vector<Corner>> find_board(const ImageF& image, const BoardPattern& pattern);

}  // namespace fringetwin::calib
