// SPDX-License-Identifier: Apache-2.0
// What `calibrate --projector-from` leaves: the camera model, the numbers with their uncertainty, the map of
// what is left.
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/page/origin.hpp"
#include "calib/solve/projector_from_points.hpp"

namespace fringetwin::calib {

/// Returns the sentences that tell the result; what is by convention is named.
std::vector<std::string> projector_lines(const ProjectorFromPoints& solved);

struct ProjectorFiles {
  std::filesystem::path dir;
  std::array<int, 2> imagersize_px{};             ///< of the projector
  int camera_width_px = 0, camera_height_px = 0;  ///< of the camera whose tiles the residuals are
  double mm_per_model_unit = 1000.0;              ///< length unit of the .cameramodel
};

/// Writes projector.cameramodel, projector_residual.png (mean residual of each tile of the first camera's
/// image, projector px) and, last, projector.json.
void write_projector(const ProjectorFromPoints& solved, const ProjectorFiles& files, const Origin& origin);

}  // namespace fringetwin::calib
