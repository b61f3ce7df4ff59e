// SPDX-License-Identifier: Apache-2.0
// Reads and writes .cameramodel files bit-exactly and locale-free (libmrcal's own writer rounds to
// 6 decimals and its reader breaks under a comma locale).
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin {

struct CameraModelFile {
  std::string lensmodel = {};
  std::vector<double> intrinsics = {};
  std::array<double, 6> rt_cam_ref{};  ///< 'extrinsics' / 'rt_cam_ref', in the file's own length unit
  std::array<int, 2> imagersize{};
  std::vector<std::string> comments = {};  ///< leading '#' lines, without '#'
  std::string extra = {};  ///< other keys verbatim ("'icam_intrinsics': 2,\n…"), kept on rewrite
};

/// Reads a file. Throws UserError(input) with file and line.
CameraModelFile read_cameramodel(const std::filesystem::path& file);
/// Writes the shortest decimals that read back as the same numbers, to a temporary name that is then renamed.
void write_cameramodel(const std::filesystem::path& file, const CameraModelFile& model);

}  // namespace fringetwin
