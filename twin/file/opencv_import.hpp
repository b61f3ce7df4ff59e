// SPDX-License-Identifier: Apache-2.0
// Turns a calibration that OpenCV wrote as YAML, XML or JSON into a lens model and a pose.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin {

/// Names the matrices of a device. Where several files have one of that name the file stands before it:
/// "left.yml:M1".
struct OpenCvDevice {
  std::string matrix_key;      ///< e.g. "M1"; 3x3
  std::string distortion_key;  ///< e.g. "D1"; 4, 5, 8 or 12 coefficients; "none" for no distortion
  std::string rotation_key;    ///< e.g. "Rlp"; empty = identity. x_device = R x_ref + T
  std::string translation_key;
};
struct OpenCvModel {
  std::string lensmodel;  ///< OPENCV4/5/8/12 by the number of coefficients; PINHOLE without distortion
  std::vector<double> intrinsics;
  std::array<double, 6> rt_device_ref{};  ///< in the file's unit (normally mm)
  std::filesystem::path matrix_file;      ///< which of the files has the camera matrix
  /// image_width and image_height of that file; empty where it lacks one.
  std::optional<std::array<int, 2>> stated_imagersize_px;
};

/// Reads one device out of the files. Throws UserError(input) naming file and key for a missing key, one that
/// stands in several files, a wrong shape, or a matrix that is no rotation (determinant, orthogonality).
OpenCvModel import_opencv(const std::vector<std::filesystem::path>& files, const OpenCvDevice& device);
/// Returns all matrix keys with their shapes, to help the user name them.
std::vector<std::string> list_opencv_keys(const std::filesystem::path& file);

}  // namespace fringetwin
