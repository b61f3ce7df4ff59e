// SPDX-License-Identifier: Apache-2.0
// A rig that looks at a printed chessboard or grid of circles under fringes in both directions: its rough and
// its true twin, and the pictures our renderer makes of it.
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "calib/solve/problem.hpp"

namespace fringetwin::testing {

struct RenderedBoards {
  /// Cameras of 1440 / reduction x 1080 / reduction pixels (the paper's have reduction 1).
  int reduction = 2;
  int n_boards = 14;
  calib::Board board{10, 7, 10.0};  ///< 11 x 8 squares: not the same upside down
  double circle_diameter_mm = 0.0;  ///< > 0: circles on the corners, no squares

  bool right_upside_down = false;  ///< the second camera stands on its head

  struct Device {
    std::string name;
    std::array<int, 2> size;
    std::array<double, 8> intrinsics;  ///< LENSMODEL_OPENCV4
    RotTrans rt_cam_world;             ///< rad, mm
  };
  std::vector<Device> devices() const;
  Pose T_world_board(int pose) const;

  /// DIR/rough.toml (pinholes, focal lengths 15 % off) and, rendered, DIR/pose00 …; returns the folders.
  std::vector<std::string> render(const std::filesystem::path& dir) const;

 private:
  std::string devices_toml(bool rough) const;
};

}  // namespace fringetwin::testing
