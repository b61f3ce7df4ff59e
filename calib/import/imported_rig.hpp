// SPDX-License-Identifier: Apache-2.0
// Reads foreign calibrations (Kalibr, plain matrices) into the devices that every importer returns.
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/lens/pose.hpp"

namespace fringetwin::calib {

struct ImportedDevice {
  std::string name;
  std::string lensmodel;
  std::vector<double> intrinsics;
  std::array<int, 2> imagersize_px{};
  Pose T_device_ref;       ///< mm
  std::string extra;       ///< of a .cameramodel: other keys, kept
  std::string where = {};  ///< the file, and the place in it, for sentences about this device
};

/// A Kalibr camchain (camN: camera_model, intrinsics, distortion_model, distortion_coeffs, resolution,
/// T_cn_cnm1). pinhole with radtan (LENSMODEL_OPENCV4), plumb_bob or none; T_cn_cnm1 maps points of the
/// camera before to this one, in metres. Throws UserError(input) with file, camera and key; other models
/// (equidistant, omni, eucm, ds) have no equal among mrcal's and are refused.
std::vector<ImportedDevice> import_kalibr(const std::filesystem::path& file);

/// Files of numbers as numpy.savetxt writes them (blanks or commas; # comments; brackets are passed over).
struct MatrixFiles {
  std::filesystem::path camera_matrix;  ///< 3x3
  std::filesystem::path distortion;     ///< 4, 5, 8, 12 (14 without tilt) numbers; empty: none
  std::filesystem::path rotation;  ///< 3x3, 3 (Rodrigues), or 3x4 / 4x4 with the translation; empty: identity
  std::filesystem::path translation;  ///< 3 numbers; empty with 3x4, 4x4 or no rotation
};
/// x_device = R x_ref + T, T in units of mm_per_unit. Throws UserError(input) naming the file.
ImportedDevice import_matrices(const MatrixFiles& files, double mm_per_unit);

/// The nearest rotation. Throws UserError(input) unless R is one to 1e-5.
Eigen::Matrix3d checked_rotation(const Eigen::Matrix3d& R, const std::string& where);

}  // namespace fringetwin::calib
