// SPDX-License-Identifier: Apache-2.0
// From pictures alone: our renderer shows a printed chessboard to two cameras under fringes in both
// directions, with shot noise; `calibrate --twin` must find the rig that was rendered. Fourteen boards,
// cameras of half the paper's resolution.
//
// | check                            | tolerance        | origin                                          |
// |----------------------------------|------------------|-------------------------------------------------|
// | the rig within its own sigmas    | rendered_rig.hpp | the rig that was rendered                       |
// | corners, cameras and projector   | 0.05, 0.06 px    | cornerSubPix on 8 bit, shot noise; 1.7 to 3     |
// |                                  |                  | times what is measured                          |
#include <gtest/gtest.h>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/rendered_rig.hpp"

namespace fringetwin::testing::calibrate_rendered_full_test {
namespace {

TEST(CalibrateRendered, FullRig) {
  FT_NEED_DEVICE();
  expect_the_rig_is_found({}, {0.05, 0.06});
}

}  // namespace
}  // namespace fringetwin::testing::calibrate_rendered_full_test
