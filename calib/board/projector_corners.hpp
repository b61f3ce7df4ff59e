// SPDX-License-Identifier: Apache-2.0
// Makes the projector a camera: finds which of its pixels light the corners of the board, from decoded
// fringes.
#pragma once
#include <cmath>
#include <vector>

#include "calib/board/observations.hpp"
#include "measure/decode/decode.hpp"

namespace fringetwin::calib {

struct ProjectorCornerOptions {
  /// Half side of the square of pixels around a corner that the projector coordinate is fitted over, as a
  /// fraction of the distance to the nearest corner, and at most so many pixels.
  double reach = 0.45;
  int largest_reach_px = 40;
  /// The fit needs valid pixels in this share of the window (half of a chessboard is too dark), on all sides.
  double least_share = 0.2;
  /// Noise of the camera's corners: what the reading inherits, times how fast the coordinate changes there.
  double camera_corner_sigma_px = 0.05;
};

/// A projector corner with the standard error of its two coordinates (rms of both).
struct ProjectorCorner {
  Eigen::Vector2d q_px = Eigen::Vector2d::Zero();
  double sigma_px = 0.0;      ///< of the reading; 0 = not decoded
  double inherited_px = 0.0;  ///< of the camera's corner, which it was read at: large where a camera grazes
  bool seen() const { return sigma_px > 0.0; }
  double total_sigma_px() const { return std::hypot(sigma_px, inherited_px); }
};

/// Around each corner seen by the camera, a quadratic in the camera's pixels is fitted robustly to the
/// decoded column and to the row, and read at the corner: the noise of one pixel (or the rounding of a
/// one-pixel Gray code) is averaged down, and dark squares are bridged. `decode` must hold both directions.
std::vector<ProjectorCorner> projector_corners(const measure::CameraDecode& decode, const Board& board,
                                               const std::vector<Corner>& camera_corners,
                                               const ProjectorCornerOptions& options = {});

/// Mean of several cameras' readings of the same corners, by their total sigmas.
std::vector<ProjectorCorner> mean_of_cameras(const std::vector<std::vector<ProjectorCorner>>& readings);

/// Returns the corners as the solve takes them: weight = s / total sigma, at most 1, where a tenth of the
/// corners of all views are better than s.
std::vector<std::vector<Corner>> weighted_corners(const std::vector<std::vector<ProjectorCorner>>& views);

}  // namespace fringetwin::calib
