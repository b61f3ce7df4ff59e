// SPDX-License-Identifier: Apache-2.0
// A calibration problem as libmrcal sees it: fixed devices look at one moving board. Part of the door to
// libmrcal (mrcal_facade.hpp). Lengths in METRES here: libmrcal's state scales assume them.
#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <string>
#include <vector>

#include "twin/lens/pose.hpp"

namespace fringetwin {

struct MrcalProblem {
  struct View {
    int device = 0, frame = 0;
  };
  std::string lensmodel;                        ///< one for all devices
  std::vector<std::vector<double>> intrinsics;  ///< per device; seed, then solution
  std::vector<std::array<int, 2>> imagersizes;  ///< per device
  std::vector<RotTrans> rt_cam_ref;             ///< of devices 1, 2, …; device 0 is the reference; rad, m
  std::vector<RotTrans> rt_ref_frame;           ///< of the board in each frame; rad, m
  Eigen::Vector2d warp_m = Eigen::Vector2d::Zero();
  std::vector<View> views;  ///< sorted by frame, then device
  /// Per view height_n x width_n corners, row by row: x, y (px), weight; weight <= 0 = not used. A
  /// residual is weight (predicted - observed).
  std::vector<Eigen::Vector3d> corners;
  double spacing_m = 0.0;
  int width_n = 0, height_n = 0;
  bool optimize_core = true, optimize_distortion = true, optimize_geometry = true, optimize_warp = true;
  bool regularize = true;

  std::size_t corners_per_view() const { return static_cast<std::size_t>(width_n) * height_n; }
};

/// Solves in place, without libmrcal's own outlier rejection (it has no floor and one threshold for all
/// devices). Returns the residuals at the optimum, those of the corners first (2 per corner, in order; 0
/// where not used), then those of the regularisation. They may be non-finite: the caller checks.
Eigen::VectorXd mrcal_solve(MrcalProblem& problem);

/// The problem linearised where it stands.
struct MrcalLinearisation {
  Eigen::SparseMatrix<double> Jt;  ///< states x measurements, in libmrcal's unitless ("packed") states
  Eigen::VectorXd residuals;
  Eigen::VectorXd state_scale;                               ///< state = scale * packed state
  int n_corner_rows = 0;                                     ///< the rest is regularisation
  std::vector<int> intrinsics_at, extrinsics_at, frames_at;  ///< first state of each; -1 = not a state
  int n_intrinsics = 0;                                      ///< states of one device's lens
  int first_intrinsic = 0;  ///< index of the parameter that is its first state (4 where the core is fixed)
  int warp_at = -1;         ///< first of two states
};
MrcalLinearisation mrcal_linearise(const MrcalProblem& problem);

}  // namespace fringetwin
