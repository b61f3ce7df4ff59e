// SPDX-License-Identifier: Apache-2.0
// The order of corners read from another end of the board, and in a mirror. No tolerances: corners are moved,
// not computed.
#include "calib/board/corner_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "twin/base/errors.hpp"

namespace fringetwin::calib::corner_order_test {
namespace {

/// Corners of a board in a plain picture: 10 px apart, rows to the right and down, 0.5 px off the grid.
std::vector<Corner> grid(const Board& board) {
  std::vector<Corner> corners;
  for (int row = 0; row < board.height_n; ++row)
    for (int col = 0; col < board.width_n; ++col)
      corners.push_back({{100.0 + 10.0 * col, 80.0 + 10.0 * row + 0.5 * (col % 2)}, 1.0});
  return corners;
}

TEST(CornerOrder, TurnsAreToldFromTheCornersThemselves) {
  for (const Board& board : {Board{8, 6, 20.0}, Board{7, 7, 20.0}, Board{9, 2, 20.0}}) {
    const std::vector<Corner> right = grid(board);
    EXPECT_EQ(turn_beside(board, right, right), nullptr);
    std::vector<Corner> reversed(right.rbegin(), right.rend());
    reversed[2] = {};  // one that is not seen
    for (Corner& corner : reversed) corner.q_px.x() += 1.0;
    ASSERT_EQ(turn_beside(board, right, reversed), &kReverseOrder);
    EXPECT_EQ(reordered(board, reversed, kReverseOrder)[0].q_px.x(), 101.0);
  }
}

TEST(CornerOrder, AQuarterTurnOnlyOfASquareBoard) {
  const Board square{6, 6, 20.0};
  const std::vector<Corner> right = grid(square);
  std::vector<Corner> turned;  // its rows are the columns, from below
  for (int col = 0; col < 6; ++col)
    for (int row = 5; row >= 0; --row) turned.push_back(right[static_cast<std::size_t>(6 * row + col)]);
  const CornerOrder* order = turn_beside(square, right, turned);
  ASSERT_NE(order, nullptr);
  const std::vector<Corner> back = reordered(square, turned, *order);
  for (std::size_t i = 0; i < right.size(); ++i) EXPECT_EQ(back[i].q_px, right[i].q_px) << i;
}

TEST(CornerOrder, NothingIsTurnedThatDoesNotFit) {
  const Board board{8, 6, 20.0};
  const std::vector<Corner> right = grid(board);
  std::vector<Corner> elsewhere(right.rbegin(), right.rend());
  for (Corner& corner : elsewhere) corner.q_px.y() += 6.0;
  EXPECT_EQ(turn_beside(board, right, elsewhere), nullptr);
  std::vector<Corner> few(right.size());
  for (std::size_t i = 0; i < 5; ++i) few[i] = right[right.size() - 1 - i];
  EXPECT_EQ(turn_beside(board, right, few), nullptr);
}

TEST(CornerOrder, AMirrorIsTold) {
  const Board board{8, 6, 20.0};
  const std::vector<Corner> right = grid(board);
  for (const CornerOrder& order : kCornerOrders) {
    if (order.transpose) continue;
    EXPECT_EQ(mirrored_share(board, reordered(board, right, order)), order.is_mirrored() ? 1.0 : 0.0);
  }
  EXPECT_TRUE(std::isnan(mirrored_share(board, std::vector<Corner>(board.corners()))));
  std::vector<Corner> few = reordered(board, right, kCornerOrders[1]);
  for (std::size_t i = 14; i < few.size(); ++i) few[i] = Corner();  // eight and six corners: five cells
  EXPECT_TRUE(std::isnan(mirrored_share(board, few)));
}

}  // namespace
}  // namespace fringetwin::calib::corner_order_test
