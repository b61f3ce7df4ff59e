// SPDX-License-Identifier: Apache-2.0
// Turns pictures and fringe captures of the board into corner files.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calib/board/board_detector.hpp"
#include "calib/board/corners_vnl.hpp"
#include "calib/board/projector_corners.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib {

struct Picture {
  std::filesystem::path file;
  RightSize right;
};

/// Looks for the board in each picture; a picture without one has no corners (and is warned about). Throws
/// UserError(input) when no picture shows the board, and for a picture of another size.
std::vector<ImageCorners> detect_in_pictures(const std::vector<Picture>& pictures,
                                             const BoardPattern& pattern);

/// The picture of a capture that shows the scene evenly lit: the white one, else the mean of the phase steps
/// (or of a code and its inverse).
ImageF evenly_lit(const CameraImages& images, const Fringes& fringes);

/// Each folder is a capture set of the board at rest, named like the folder: the corners of every camera of
/// the twin, and of its projector (mean over the cameras that see a corner, by their sigmas). Files are named
/// "CAMERA-FOLDER" and "projector-FOLDER". Corners of a camera with a channel are places of its whole sensor.
std::vector<ImageCorners> detect_in_captures(const Twin& twin,
                                             const std::vector<std::filesystem::path>& folders,
                                             const BoardPattern& pattern);

}  // namespace fringetwin::calib
