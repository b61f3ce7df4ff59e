// SPDX-License-Identifier: Apache-2.0
// Noise of values that are read between the pixels of an image (measure/points/coordinate_map.hpp: Lagrange
// cubics of 4 x 4 pixels).
#pragma once
#include <Eigen/Core>

namespace fringetwin::study {

/// Of independent pixels of variance 1, averaged over the place between them: covariance of two values that
/// are `distance_px` apart along one axis. 733/945 for 0; 0 from 4 on. Along both axes: the product.
double interpolation_covariance(double distance_px);

/// Points on a lattice, columns of `step_px` apart: variance of their sum, per point. For a dense lattice
/// that is 1/|det(step_px)|, the points that a pixel has.
double lattice_variance(const Eigen::Matrix2d& step_px);

}  // namespace fringetwin::study
