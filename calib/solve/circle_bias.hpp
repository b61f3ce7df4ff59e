// SPDX-License-Identifier: Apache-2.0
// Corrects detected circles: a detector finds the centroid of a circle's picture, but the picture of the
// circle's centre lies elsewhere (Heikkilä, "Geometric Camera Calibration Using Circular Control Points",
// PAMI 22, 2000).
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/board/observations.hpp"
#include "calib/solve/problem.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::calib {

/// Centroid (px) of the picture of a disc of the board: the mean of the projection over the disc, weighted
/// with the area each of its parts has in the picture. Integrated over the disc, so it holds with distortion,
/// where the picture is no ellipse; exact to 1e-6 px for discs of some tens of pixels. nullopt where the lens
/// does not project the disc.
std::optional<Eigen::Vector2d> disc_centroid_px(const Lens& lens, const Pose& T_device_board,
                                                const Eigen::Vector3d& center_mm, double radius_mm);

/// Corners as the solver takes them (solver_corners()), but of the circles' centres: from the centroids
/// observed and where `problem` has the boards. A camera's move by the difference between centroid and
/// centre; a projector's were read where the cameras saw the centroid, so they move by what lies between
/// there and the centre on the board (weighted mean over the cameras that see it).
std::vector<Eigen::Vector3d> circle_centres(const MrcalProblem& problem, const Observations& observed,
                                            double diameter_mm);

}  // namespace fringetwin::calib
