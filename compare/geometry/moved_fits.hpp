// SPDX-License-Identifier: Apache-2.0
// Says what the fits of both sides would differ by if the twin's objects stood elsewhere or had other sizes,
// without rendering or measuring anything.
#pragma once
#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns the rows of spheres, planes and cylinders that were fitted on both sides, the simulated fit moved,
/// turned and grown as the object of `changed` is against that of `twin`: what the method adds to a fit
/// moves along, to first order. Rows of other shapes are left out.
std::vector<FitRow> moved_fits(const std::vector<FitRow>& rows, const Twin& twin, const Twin& changed);

/// Returns the z of every number of these rows that has one, by "ball.radius_mm", "ball.center_mm.x".
std::map<std::string, double> z_by_name(const std::vector<FitRow>& rows);

/// Returns z of fits that were moved by values which are themselves not known exactly: each over the root of
/// 1 + s' C s, with its derivatives s by the values (a row of `slopes`) and the values' covariance C.
Eigen::VectorXd with_uncertain_values(const Eigen::VectorXd& z, const Eigen::MatrixXd& slopes,
                                      const Eigen::MatrixXd& covariance);

}  // namespace fringetwin::compare
