// SPDX-License-Identifier: Apache-2.0
// Settles the harmonics that all fringes have at far more pixels than a fit of many parameters looks at.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/parameter.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Gray values of a camera that are looked at, at most: 16 MB per harmonic's part.
inline constexpr std::size_t kMostSettledValues = 4'000'000;

/// Returns whether the parameters have harmonics of all fringes whose derivatives need no rendering, beside
/// others that a twin can hold while they are settled; `told`: which of them the images tell.
bool can_settle_harmonics(const Twin& twin, const std::vector<Parameter>& parameters,
                          const std::vector<bool>& told);

/// Returns the values with those harmonics as the samples of `all`, which has the sensors and the free
/// numbers per pixel of the fit, tell them, the others as they are. A fit leaves them wrong by what noise
/// does to its own pixels, and over all of them that is a ripple of the phase beyond chance.
Eigen::VectorXd with_settled_harmonics(Sensitivity& all, const Twin& twin,
                                       const std::vector<Parameter>& parameters,
                                       const std::vector<bool>& told, const Eigen::VectorXd& values,
                                       bool hold_gain);

}  // namespace fringetwin::compare
