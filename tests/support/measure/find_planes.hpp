// SPDX-License-Identifier: Apache-2.0
// Finds the largest planes in a cloud of points that holds other things as well.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "measure/fit/fits.hpp"

namespace fringetwin::testing {

/// Returns up to `count` planes by RANSAC (PCL), the largest first, each refined by fit_plane() on the points
/// within threshold_mm of it, whose indices go to `inliers`.
std::vector<measure::PlaneFit> find_planes(const std::vector<Eigen::Vector3d>& p_mm, int count,
                                           double threshold_mm,
                                           std::vector<std::vector<std::size_t>>* inliers = nullptr);

}  // namespace fringetwin::testing
