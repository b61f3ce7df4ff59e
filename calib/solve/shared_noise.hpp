// SPDX-License-Identifier: Apache-2.0
// Estimates from a calibration's residuals how much of the cameras' noise the projector's corners share: a
// projector's corner is read where the cameras found the corner of the board, so it inherits their error.
#pragma once
#include <Eigen/SparseCore>

#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

/// Noise of a projector's corner = share * (weighted mean over the cameras of what their noise moves it by on
/// the board)
/// + noise of its own. The share follows from the residuals: 1 where every reading was taken at the cameras'
/// corners, 0 for corners measured by themselves.
struct SharedNoise {
  double share = 0.0;
  double camera_sigma_px = 0.0, projector_sigma_px = 0.0;  ///< own noise, weighted pixels (per coordinate)
  /// Residual rows x independent unit noises: residuals = -factor * noises. Empty when nothing is shared.
  Eigen::SparseMatrix<double> factor;
};

/// `residuals` as libmrcal orders them, with those of the regularisation.
SharedNoise shared_noise(const Calibration& calibration, const Eigen::VectorXd& residuals);

}  // namespace fringetwin::calib
