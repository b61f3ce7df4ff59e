// SPDX-License-Identifier: Apache-2.0
// Checks imported poses against points that several devices saw: poses and matched pixels go in, and for each
// way in which a file's R, T can be meant the epipolar and reprojection errors come out. Files do not say
// whether R, T map from the first device to the other one or back.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calib/import/imported_rig.hpp"

namespace fringetwin::calib {

/// Holds the pixels at which the devices saw the same points: q_px[point][device], NaN where not seen.
struct Correspondences {
  std::filesystem::path file;
  std::vector<std::vector<Eigen::Vector2d>> q_px;
};

/// Reads a .vnl corner file (images of a device begin with its name; corners of one frame and number
/// correspond), or a table of numbers: two columns per device in the order of `devices`, one point a row, "-"
/// or nan where not seen, a heading allowed. Throws UserError(input).
Correspondences read_correspondences(const std::filesystem::path& file,
                                     const std::vector<ImportedDevice>& devices);

/// Names the ways in which the R, T of a device can be meant.
enum class PoseConvention { as_given, inverted, rotation_transposed, translation_negated };
const char* convention_name(PoseConvention convention);
/// Returns T_device_first when the R, T that were read as `given` are meant in this way.
Pose with_convention(const Pose& given, PoseConvention convention);

struct ConventionFit {
  PoseConvention convention = PoseConvention::as_given;
  double epipolar_px = 0.0;  ///< rms distance of the points from their epipolar lines, in the second device
  double in_front = 0.0;     ///< share of the points that lie in front of both
  /// rms distance per image and point between seen and reprojected pixels after triangulation; NaN where
  /// fewer than half of the points lie in front.
  double reprojection_px = 0.0;
};

/// Holds what was found for one device together with the first one.
struct DeviceCheck {
  std::string device = {};
  std::size_t n = 0;
  std::vector<ConventionFit> fits = {};  ///< order of the enum
  PoseConvention best = PoseConvention::as_given;
  bool fits_any = false;  ///< `best` has the points in front, and within max_px of their epipolar lines
};

/// Returns one check for each device after the first. A convention fits when at least 90 % of the points lie
/// in front of both devices and the epipolar distance is at most max_px; the best has the smallest distance,
/// as_given and inverted before the others within a factor of 1.5. Throws UserError(input) for a device with
/// fewer than 8 points.
std::vector<DeviceCheck> check_poses(const std::vector<ImportedDevice>& devices, const Correspondences& seen,
                                     double max_px);

}  // namespace fringetwin::calib
