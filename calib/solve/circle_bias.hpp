// SPDX-License-Identifier: Apache-2.0
// Corrects detected circles for the perspective bias: a detector finds the centroid of a circle's image, but
// the image of the circle's centre lies elsewhere (Heikkilä, "Geometric Camera Calibration Using Circular
// Control Points", PAMI 22, 2000).
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/board/observations.hpp"
#include "calib/solve/problem.hpp"
#include "twin/lens/lens.hpp"

namespace fringetwin::calib {

/// Returns the centroid (px) of the image of a disc of the board: the mean of the projection over the disc,
/// weighted with the area that each of its parts has in the image. It is integrated over the disc, so it
/// holds with lens distortion, where the image is no ellipse; exact to 1e-6 px for discs of some tens of
/// pixels. nullopt where the lens does not project the disc.
std::optional<Eigen::Vector2d> disc_centroid_px(const Lens& lens, const Pose& T_device_board,
                                                const Eigen::Vector3d& center_mm, double radius_mm);

/// Returns the observed corners in the form of solver_corners(), moved from the centroids of the circles to
/// their centres, for the poses that `problem` has at present. A camera's corner moves by the difference
/// between centroid and centre. A projector's corner was read where the cameras saw the centroid, so it moves
/// by the difference between the projections of that point of the board and of the centre (weighted mean over
/// the cameras that see it).
std::vector<Eigen::Vector3d> circle_centres(const MrcalProblem& problem, const Observations& observed,
                                            double diameter_mm);

}  // namespace fringetwin::calib
