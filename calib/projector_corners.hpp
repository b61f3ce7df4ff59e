// SPDX-License-Identifier: Apache-2.0
// The projector as a camera: which of its pixels light the corners of the board.
#pragma once
#include <vector>

#include "calib/observations.hpp"
#include "measure/decode.hpp"

namespace fringetwin::calib {

struct ProjectorCornerOptions {
  /// Half side of the square of pixels around a corner that the projector coordinate is fitted over, as a
  /// fraction of the distance to the nearest corner, and at most so many pixels.
  double reach = 0.45;
  int largest_reach_px = 40;
  /// The fit needs valid pixels in this share of the window (half of a chessboard is too dark), on all sides.
  double least_share = 0.2;
};

/// A projector corner with the standard error of its two coordinates.
struct ProjectorCorner {
  Eigen::Vector2d q_px = Eigen::Vector2d::Zero();
  double sigma_px = 0.0;  ///< of a coordinate (rms of both); 0 = not decoded
  bool seen() const { return sigma_px > 0.0; }
};

/// Around each corner seen by the camera, a quadratic in the camera's pixels is fitted robustly to the
/// decoded column and to the row, and read at the corner: the noise of one pixel (or the rounding of a
/// one-pixel Gray code) is averaged down, and dark squares are bridged. `decode` must hold both directions.
std::vector<ProjectorCorner> projector_corners(const measure::CameraDecode& decode, const Board& board,
                                               const std::vector<Corner>& camera_corners,
                                               const ProjectorCornerOptions& options = {});

/// As corners for the solve: weight = median sigma / sigma, at most 1, so that the best count like a
/// camera's.
std::vector<Corner> weighted_corners(const std::vector<ProjectorCorner>& corners);

}  // namespace fringetwin::calib
