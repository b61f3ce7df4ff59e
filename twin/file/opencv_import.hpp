// SPDX-License-Identifier: Apache-2.0
// Turns a calibration that OpenCV wrote as YAML, XML or JSON into a lens model and a pose.
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin {

struct OpenCvDevice {
  std::string matrix_key;      ///< e.g. "M1"; 3x3
  std::string distortion_key;  ///< e.g. "D1"; 4, 5, 8 or 12 coefficients
  std::string rotation_key;    ///< e.g. "Rlp"; empty = identity. x_device = R x_ref + T
  std::string translation_key;
};
struct OpenCvModel {
  std::string lensmodel;  ///< OPENCV4/5/8/12 by the number of coefficients
  std::vector<double> intrinsics;
  std::array<double, 6> rt_device_ref{};  ///< in the file's unit (normally mm)
};

/// Reads one device out of the files. Throws UserError(input) naming file and key for a missing key, wrong
/// shape, or a matrix that is no rotation (determinant, orthogonality).
OpenCvModel import_opencv(const std::vector<std::filesystem::path>& files, const OpenCvDevice& device);
/// Returns all matrix keys with their shapes, to help the user name them.
std::vector<std::string> list_opencv_keys(const std::filesystem::path& file);

}  // namespace fringetwin
