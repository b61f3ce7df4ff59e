// SPDX-License-Identifier: Apache-2.0
// Calibrates the same rig twice, from the even and from the odd frames, and returns by how many pixels the
// projections of the two differ, beside the difference that the noise of the corners predicts. A larger one
// reveals errors that the noise model leaves out: a lens model that does not fit, a board that bends.
// mrcal calls this cross-validation.
#pragma once
#include <string>
#include <vector>

#include "calib/solve/calibration.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

/// Holds how far the projections of one device by two calibrations differ, after the rigid motion between the
/// two calibrations (6 numbers) is taken out.
struct ProjectionDifference {
  ImageF difference_px;  ///< over a grid of pixels covering the imager; NaN where not defined
  ImageF expected_px;    ///< worst-direction sigma of the difference, from the noise of the corners
  double rms_px = 0.0, max_px = 0.0;
  double relative = 0.0;  ///< rms of difference / expected
};

/// Holds the result for all devices.
struct CrossValidation {
  int n_even = 0, n_odd = 0;
  std::string not_done;  ///< the reason why the halves could not be compared; empty when they were
  std::vector<ProjectionDifference> devices;
  /// rms distance between points of the working volume and what they become when one calibration projects
  /// them and the other triangulates them, after rigid alignment; NaN with one device.
  double shape_rms_mm = 0.0;
};

/// Returns by how much the two calibrations differ in where they project the points at the working distance
/// that a grid of `columns` x rows pixels sees.
ProjectionDifference projection_difference(const Calibration& a, const Calibration& b, int device,
                                           double distance_mm, int columns = 24);

/// Compares the calibrations of the even and the odd frames; sets not_done when either half cannot be
/// calibrated. Both halves leave out the outliers of the whole and reject no others.
CrossValidation cross_validate(const Calibration& whole, const CalibrateOptions& options);

}  // namespace fringetwin::calib
