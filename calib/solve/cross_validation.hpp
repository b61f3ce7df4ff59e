// SPDX-License-Identifier: Apache-2.0
// Calibrates the same rig twice, from the even and from the odd frames, and returns how far the two differ:
// errors that the boards do show, whether the model of noise knows them or not.
#pragma once
#include <string>
#include <vector>

#include "calib/solve/calibration.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

/// How far the projections of one device by two calibrations differ, after the rigid motion between the two
/// calibrations (6 numbers) is taken out.
struct ProjectionDifference {
  ImageF difference_px;  ///< over a grid of pixels covering the imager; NaN where not defined
  ImageF expected_px;    ///< worst-direction sigma of the difference, from the noise of the corners
  double rms_px = 0.0, max_px = 0.0;
  double relative = 0.0;  ///< rms of difference / expected
};

struct CrossValidation {
  int n_even = 0, n_odd = 0;
  std::string not_done;  ///< why there is none; empty when there is
  std::vector<ProjectionDifference> devices;
  /// Points of the working volume, projected by one rig and triangulated by the other, after rigid alignment;
  /// NaN with one device.
  double shape_rms_mm = 0.0;
};

/// Returns by how much the two calibrations differ in where they project the points at the working distance
/// that a grid of `columns` x rows pixels sees.
ProjectionDifference projection_difference(const Calibration& a, const Calibration& b, int device,
                                           double distance_mm, int columns = 24);

/// Compares the calibrations of the two halves; says why not (not_done) when either cannot be calibrated. The
/// halves are solved like the whole, which decides what is an outlier.
CrossValidation cross_validate(const Calibration& whole, const CalibrateOptions& options);

}  // namespace fringetwin::calib
