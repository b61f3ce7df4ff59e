// SPDX-License-Identifier: Apache-2.0
// Estimates the standard errors that published numbers without any would have, from their rms and the
// simulated points (docs/metrics/geometry.md, "Fits").
#pragma once
#include "compare/result/rows.hpp"
#include "measure/points/points.hpp"

namespace fringetwin::compare {

/// Fills row.real_sigma_estimated and row.z_estimated for what has no z because the real side gives an rms
/// but no standard errors: as if its points were the simulated ones, with independent errors of that rms.
/// Spheres only; anything else is left as it is.
void estimate_published_z(const measure::PointCloud& simulated, FitRow& row);

}  // namespace fringetwin::compare
