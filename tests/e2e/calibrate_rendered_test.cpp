// SPDX-License-Identifier: Apache-2.0
// From pictures alone: our renderer shows a printed chessboard to two cameras under fringes in both
// directions, with shot noise; `calibrate --twin` must find the rig that was rendered. Few boards and
// quarter-size cameras.
//
// | check                            | tolerance        | origin                                          |
// |----------------------------------|------------------|-------------------------------------------------|
// | the rig within its own sigmas    | rendered_rig.hpp | the rig that was rendered                       |
// | corners, cameras and projector   | 0.08, 0.12 px    | cornerSubPix on 8 bit, shot noise; 1.7 to 3     |
// |                                  |                  | times what is measured                          |
// | circles, cameras and projector   | 0.02, 0.04 px    | twice what is measured                          |
#include <gtest/gtest.h>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/rendered_rig.hpp"

namespace fringetwin::testing::calibrate_rendered_test {
namespace {

RenderedBoards few_boards() {
  RenderedBoards scene;
  scene.reduction = 4;
  scene.n_boards = 4;
  return scene;
}

TEST(CalibrateRendered, FewBoards) {
  FT_NEED_DEVICE();
  expect_the_rig_is_found(few_boards(), {0.08, 0.12});
}

// The board of 11 x 8 squares is read from its one end whichever way up the camera is.
TEST(CalibrateRendered, ACameraUpsideDown) {
  FT_NEED_DEVICE();
  RenderedBoards scene = few_boards();
  scene.right_upside_down = true;
  expect_the_rig_is_found(scene, {0.08, 0.12});
}

// One of 11 x 9 looks the same from both ends: the fringes tell them apart.
TEST(CalibrateRendered, ACameraUpsideDownAndABoardThatLooksTheSame) {
  FT_NEED_DEVICE();
  RenderedBoards scene = few_boards();
  scene.n_boards = 6;  // a board of that size leaves the right image in one of them
  scene.board = {10, 8, 10.0};
  scene.right_upside_down = true;
  expect_the_rig_is_found(scene, {0.08, 0.12});
}

// The same with circles, whose centroids are not their centres' pictures: up to half a pixel here.
TEST(CalibrateRendered, CirclesInsteadOfSquares) {
  FT_NEED_DEVICE();
  RenderedBoards scene;
  scene.reduction = 3;
  scene.n_boards = 4;
  scene.circle_diameter_mm = 5.0;
  expect_the_rig_is_found(scene, {0.02, 0.04});
}

}  // namespace
}  // namespace fringetwin::testing::calibrate_rendered_test
