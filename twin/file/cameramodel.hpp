// SPDX-License-Identifier: Apache-2.0
// .cameramodel files, read and written bit-exactly and locale-free (libmrcal's own writer rounds to
// 6 decimals and its reader breaks under a comma locale).
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin {

struct CameraModelFile {
  std::string lensmodel;
  std::vector<double> intrinsics;
  std::array<double, 6> rt_cam_ref{};  ///< 'extrinsics' / 'rt_cam_ref', in the file's own length unit
  std::array<int, 2> imagersize{};
  std::vector<std::string> comments;  ///< leading '#' lines, without '#'
  std::string extra;                  ///< other keys verbatim ("'icam_intrinsics': 2,\n…"), kept on rewrite
};

/// Throws UserError(input) with file and line.
CameraModelFile read_cameramodel(const std::filesystem::path& file);
/// Shortest round-trip decimals; temporary name, then rename.
void write_cameramodel(const std::filesystem::path& file, const CameraModelFile& model);

}  // namespace fringetwin
