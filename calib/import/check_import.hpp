// SPDX-License-Identifier: Apache-2.0
// Checks whether imported poses fit points that the devices saw: R, T of a file could map either way.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calib/import/imported_rig.hpp"

namespace fringetwin::calib {

/// The pixels of the same points in every device: q_px[point][device], NaN where not seen.
struct Correspondences {
  std::filesystem::path file;
  std::vector<std::vector<Eigen::Vector2d>> q_px;
};

/// A .vnl corner file (images of a device begin with its name; corners of one frame and number correspond),
/// or a table of numbers: two columns per device in the order of `devices`, one point a row, "-" or nan where
/// not seen, a heading allowed. Throws UserError(input).
Correspondences read_correspondences(const std::filesystem::path& file,
                                     const std::vector<ImportedDevice>& devices);

/// The ways in which the R, T of a device can be meant.
enum class PoseConvention { as_given, inverted, rotation_transposed, translation_negated };
const char* convention_name(PoseConvention convention);
Pose with_convention(const Pose& given, PoseConvention convention);

struct ConventionFit {
  PoseConvention convention = PoseConvention::as_given;
  double epipolar_px = 0.0;  ///< rms distance of the points from their epipolar lines, in the second device
  double in_front = 0.0;     ///< share of the points that lie in front of both
  double reprojection_px =
      0.0;  ///< rms per image and point after triangulation; NaN where fewer than half are in front
};

/// One device against the first.
struct DeviceCheck {
  std::string device;
  std::size_t n = 0;
  std::vector<ConventionFit> fits;  ///< order of the enum
  PoseConvention best = PoseConvention::as_given;
  bool fits_any = false;  ///< best: in front, and within max_px of its epipolar lines
};

/// A convention fits when at least 90 % of the points lie in front of both devices and the epipolar distance
/// is at most max_px; the best has the smallest distance, as_given and inverted before the others within a
/// factor of 1.5. Throws UserError(input) for a device with fewer than 8 points.
std::vector<DeviceCheck> check_poses(const std::vector<ImportedDevice>& devices, const Correspondences& seen,
                                     double max_px);

}  // namespace fringetwin::calib
