// SPDX-License-Identifier: Apache-2.0
// Derives from a solved calibration what a user is told of its quality: uncertainties of projection, of the
// parameters and of triangulated shape, and the cross-validation. Declares the functions that write these
// findings as calibration.json (calibration_json.cpp) and as a page (calibration_page.cpp).
#pragma once
#include <string>
#include <vector>

#include "calib/page/origin.hpp"
#include "calib/solve/calibration.hpp"
#include "calib/solve/cross_validation.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

/// Holds how well one device is calibrated.
struct DeviceFindings {
  double distance_mm = 0.0;                  ///< distance at which the sigmas hold: the boards' mean
  double centre_sigma_px = 0.0;              ///< worst-direction projection uncertainty at the image centre
  std::array<double, 4> corner_sigma_px{};   ///< at (0,0), (w-1,0), (0,h-1), (w-1,h-1); NaN where not defined
  double centre_at_infinity_sigma_px = 0.0;  ///< as above for a point at infinity
  ImageF sigma_px;                           ///< over a grid of pixels covering the imager
  std::vector<double> intrinsics_sigma;      ///< in the lens's order of parameters; NaN for fixed ones
  RotTrans rt_sigma = RotTrans::Zero();      ///< of rt_device_ref; 0 for the reference
};

/// Holds how well two devices measure together.
struct PairFindings {
  int first = 0, second = 0;
  double baseline_mm = 0.0, baseline_sigma_mm = 0.0;
  /// Calibration's contribution to the shape of what is measured where the boards were: rms over points,
  /// after the best rigid motion.
  double shape_sigma_mm = 0.0;
};

struct Findings {
  std::vector<DeviceFindings> devices;
  std::vector<PairFindings> pairs;
  double observed_sigma_px = 0.0;
  Eigen::Vector2d warp_sigma_mm = Eigen::Vector2d::Zero();
  double shared_noise = 0.0;  ///< the part of the cameras' corner noise that the projector's corners inherit
  /// Uncertainty::rig(); empty for lens models with more than 16 parameters.
  Eigen::MatrixXd rig_covariance;
  CrossValidation cross_validation;
};

/// Derives all findings; solves twice more for the cross-validation.
Findings calibration_findings(const Calibration& calibration, const CalibrateOptions& options);

/// Returns the text of calibration.json, schema "fringetwin-calibration/1" (docs/CALIBRATION.md).
std::string calibration_json(const Calibration& calibration, const CalibrateOptions& options,
                             const Findings& findings, const Origin& origin,
                             const std::vector<std::string>& model_files);

/// Returns the page as HTML: table of devices, residual maps, uncertainty maps, board poses, warp, every
/// view.
std::string calibration_html(const Calibration& calibration, const CalibrateOptions& options,
                             const Findings& findings, const Origin& origin);

/// Returns the four lines that mrcal-calibrate-cameras prints: rms error, worst residual, outliers, board
/// warp.
std::vector<std::string> summary_lines(const Calibration& calibration);

}  // namespace fringetwin::calib
