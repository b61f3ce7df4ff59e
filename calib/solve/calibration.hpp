// SPDX-License-Identifier: Apache-2.0
// A solved calibration: every device's lens and pose, the boards, and how well they fit the corners; what
// calibrate() was asked for; and the file a solved device is written to.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "calib/solve/problem.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::calib {

struct CalibrateOptions {
  std::string lensmodel = "LENSMODEL_OPENCV4";  ///< of all devices
  bool regularize = true;  ///< false: a last solve without regularisation after one with it, as mrcal does
  /// With `regularize`: it is left out of the last solve all the same where the corners determine every
  /// parameter. Its pull (fixed in pixels, so the stronger the better the corners) is in no sigma.
  bool drop_regularization = false;
  bool solve_warp = true;
  bool reject_outliers = true;
  /// Corners further from their prediction than this many robust sigmas of their own device are left out; one
  /// value, or one per device.
  std::vector<double> outlier_sigmas = {5.0};
  double max_rms_px = 2.0;  ///< per device; a worse fit is an error
  /// Device::sigma_px is only where to start: it is set to what each device's residuals scatter by.
  bool estimate_sigmas = false;
  /// > 0: the corners are centroids of the pictures of circles this large; they are corrected to the circles'
  /// centres with the poses solved, until nothing moves any more (circle_bias.hpp).
  double circle_diameter_mm = 0.0;
};

/// How well the solution fits: differences observed - predicted of the corners used.
struct FitQuality {
  double rms_px = 0.0;            ///< 2-norm per corner (OpenCV's convention)
  double rms_component_px = 0.0;  ///< per coordinate, weighted: what mrcal minimises
  double worst_px = 0.0;          ///< 2-norm
  int n_corners = 0, n_outliers = 0;
};

struct DeviceResult {
  std::string name;
  std::vector<double> intrinsics;
  Pose T_device_ref;
  FitQuality fit;
};

struct ViewResult {
  int device = 0, frame = 0;
  FitQuality fit;
};

struct Calibration {
  Observations observations;  ///< as given; sigma_px of the devices as estimated, where asked for
  MrcalProblem problem;       ///< solved; the weight of an outlier is -1; circles' corners are corrected
  double circle_correction_px = 0.0;  ///< largest correction of a circle's centre
  Eigen::VectorXd residuals;          ///< weight (predicted - observed), as libmrcal orders them
  std::vector<DeviceResult> devices;
  std::vector<ViewResult> views;  ///< as observations.views
  FitQuality fit;                 ///< of everything
  Eigen::Vector2d warp_mm = Eigen::Vector2d::Zero();
  std::vector<std::string> warnings;

  Lens lens(int device) const;
  /// predicted - observed (px) of corner `index` of view `view`; NaN where not used.
  Eigen::Vector2d residual_px(std::size_t view, std::size_t index) const;
  bool is_outlier(std::size_t view, std::size_t index) const;
  /// Mean distance of the boards along the device's axis, mm: where the rig works.
  double working_distance_mm(int device) const;
};

/// Full precision, lengths in metres, with everything mrcal needs to solve it again ('optimization_inputs');
/// `comments` without '#'.
void write_calibrated_model(const std::filesystem::path& file, const Calibration& calibration, int device,
                            const std::vector<std::string>& comments);

}  // namespace fringetwin::calib
