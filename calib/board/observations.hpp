// SPDX-License-Identifier: Apache-2.0
// The input of a calibration: the corners of one board, seen by every device in many views.
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin::calib {

/// A flat grid of corners. Corner (row, col) of the undeformed board lies at (col, row, 0) * spacing.
struct Board {
  int width_n = 0, height_n = 0;  ///< corners per row, rows
  double spacing_mm = 0.0;
  std::size_t corners() const {
    return static_cast<std::size_t>(width_n) * static_cast<std::size_t>(height_n);
  }
  double width_mm() const { return spacing_mm * (width_n - 1); }
  double height_mm() const { return spacing_mm * (height_n - 1); }
  double diagonal_mm() const;
  /// Index = row * width_n + col. warp_mm: deflection in z at the middle of the board relative to its
  /// borders, by x and by y: z = 4 wx u (1-u) + 4 wy v (1-v), u = col/(width_n-1), v = row/(height_n-1).
  Eigen::Vector3d point_mm(std::size_t index, const Eigen::Vector2d& warp_mm = Eigen::Vector2d::Zero()) const;
};

struct Corner {
  Eigen::Vector2d q_px = Eigen::Vector2d::Zero();
  double weight = -1.0;  ///< relative to the others; <= 0: not seen
  bool seen() const { return weight > 0.0; }
};

/// A camera, or a projector that is told by decoded fringes where it lights a corner.
struct Device {
  std::string name;
  std::array<int, 2> imagersize_px{};
  double focal_px = 0.0;  ///< rough; within a factor of two will do
  double sigma_px = 1.0;  ///< noise of its corners relative to the other devices' (projectors: often 2...4)
  bool is_projector = false;  ///< its corners were read where the cameras see them
};

/// One device's picture of the board in one frame (the board at rest).
struct View {
  int device = 0, frame = 0;
  std::string source;           ///< file name, for messages
  std::vector<Corner> corners;  ///< Board::corners() of them, row by row
  int n_seen() const;
};

struct Observations {
  Board board;
  std::vector<Device> devices = {};
  std::vector<std::string> frames = {};  ///< names
  std::vector<View> views = {};
  std::filesystem::path file = {};  ///< where the corners come from, for messages

  const View* find(int device, int frame) const;
  /// Views in order of frame, then device (what the solver wants); frames nobody sees are dropped.
  void sort();
  /// "left, view 007 (left007.png)"
  std::string label(const View& view) const;
  /// The label behind the file that the corners come from, for messages.
  std::string where(const View& view) const;
};

/// Throws UserError(input) with one sentence when the observations cannot be calibrated from: non-finite
/// corners, corners outside the imager, a spacing that is not in metres, too few views or corners, a device
/// without a view shared with the others.
void check_observations(const Observations& observations);

/// Only these frames.
Observations select_frames(const Observations& observations, const std::vector<int>& frames);

}  // namespace fringetwin::calib
