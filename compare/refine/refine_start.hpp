// SPDX-License-Identifier: Apache-2.0
// Finds where a refinement may begin: at the poses that fits of the objects to the real points give. A pose
// half a fringe away leads gray values astray, but not points, whose fringe orders are known. And on the
// right side of exposures on time.
#pragma once
#include <vector>

#include "compare/causes/group_fit.hpp"
#include "measure/points/points.hpp"

namespace fringetwin::compare {

/// Where a fit puts an object of the twin.
struct FittedPlace {
  std::size_t object = 0;  ///< index in the twin
  Shape shape;             ///< of the object's kind; a sphere's and a cylinder's radius are fitted, too
};

/// Returns the places of the objects whose motions are among the parameters, several of one object where its
/// fit was tried with several gates: the twin's own, 10 mm, and five times the median distance of the
/// object's points. An object's points are those nearer to it than to any other.
std::vector<FittedPlace> fitted_places(const Twin& twin, const std::vector<Parameter>& parameters,
                                       const measure::PointCloud& cloud);

/// Returns these values with those of the object's motions replaced: they bring it to the place, or as near
/// as the motions among the parameters can.
Eigen::VectorXd values_at(const Twin& twin, const std::vector<Parameter>& parameters, Eigen::VectorXd values,
                          const FittedPlace& place);

/// Returns which parameters are harmonics that are the same in all phase steps of a pixel: those of the order
/// of the steps, or of a multiple of it, where all steps are of one pitch. From pitch to pitch they differ.
std::vector<std::size_t> alike_in_all_images(const Twin& twin, const std::vector<Parameter>& parameters);

/// Lets the fit begin at each place at which the gray values fit better.
void start_at_fitted_places(GroupFit& fit, const Twin& twin, const measure::PointCloud& cloud);

/// Lets the fit begin with exposures that are late or early, whichever fits better: an exposure on time lies
/// between two valleys, of light of the pattern after and of that before.
void start_late_or_early(GroupFit& fit);

}  // namespace fringetwin::compare
