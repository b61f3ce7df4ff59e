// SPDX-License-Identifier: Apache-2.0
// Works out once, for the page and for calibration.json, what is said about a solved calibration, and writes
// both.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calib/page/origin.hpp"
#include "calib/solve/calibration.hpp"
#include "calib/solve/cross_validation.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

struct DeviceFindings {
  double distance_mm = 0.0;                  ///< where the following hold: the mean distance of its boards
  double centre_sigma_px = 0.0;              ///< worst-direction projection uncertainty at the image centre
  std::array<double, 4> corner_sigma_px{};   ///< at (0,0), (w-1,0), (0,h-1), (w-1,h-1); NaN where not defined
  double centre_at_infinity_sigma_px = 0.0;  ///< as above for a point at infinity
  ImageF sigma_px;                           ///< over a grid of pixels covering the imager
  std::vector<double> intrinsics_sigma;      ///< of the solved parameters, then NaN … in the lens's order
  RotTrans rt_sigma = RotTrans::Zero();      ///< of rt_device_ref; 0 for the reference
};

/// How well two devices measure together.
struct PairFindings {
  int first = 0, second = 0;
  double baseline_mm = 0.0;
  /// Calibration's contribution to the shape of what is measured where the boards were: rms over points,
  /// after the best rigid motion.
  double shape_sigma_mm = 0.0;
};

struct Findings {
  std::vector<DeviceFindings> devices;
  std::vector<PairFindings> pairs;
  double observed_sigma_px = 0.0;
  Eigen::Vector2d warp_sigma_mm = Eigen::Vector2d::Zero();
  double shared_noise = 0.0;  ///< of the cameras' corner noise in the projector's corners
  /// Uncertainty::rig(); empty for lens models with more than 16 parameters.
  Eigen::MatrixXd rig_covariance;
  CrossValidation cross_validation;
};

Findings analyse(const Calibration& calibration, const CalibrateOptions& options);

/// calibration.json, schema "fringetwin-calibration/1" (docs/CALIBRATION.md).
std::string calibration_json(const Calibration& calibration, const CalibrateOptions& options,
                             const Findings& findings, const Origin& origin,
                             const std::vector<std::string>& model_files);

/// The page: table of devices, residual maps, uncertainty maps, board poses, warp, every view.
std::string calibration_html(const Calibration& calibration, const CalibrateOptions& options,
                             const Findings& findings, const Origin& origin);

/// mrcal-calibrate-cameras' four lines: rms, worst residual, outliers, warp.
std::vector<std::string> summary_lines(const Calibration& calibration);

}  // namespace fringetwin::calib
