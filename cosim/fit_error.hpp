// SPDX-License-Identifier: Apache-2.0
// Says how far a fit is from another fit of the same object, and from the object that was put into the twin.
#pragma once
#include <vector>

#include "measure/measurement.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// True when a measurement with this twin ends in fits: it triangulates, and some are asked for.
bool can_fit(const Twin& twin);

/// Returns the fit of each [[measure.fit]], in their order.
std::vector<measure::ObjectFit> fits_in_order(const Twin& twin, const measure::Measurement& measurement);

/// Returns how far two fits of one object are apart, mm: sphere: the larger of the distance of the centres
/// and the difference of the radii; plane: offset at the fitted point; cylinder: the larger of axis distance
/// and radius; mesh: the largest difference of the deviations' rms, mean and 95 % quantile. For the analytic
/// shapes also the difference of the residual rms. +inf when one of the two is not usable.
double fit_distance_mm(const measure::ObjectFit& a, const measure::ObjectFit& b);

/// Returns the error of a fit against what was put in, mm: as fit_distance_mm without the residual rms; mesh:
/// the rms of the deviations from the CAD surface. NaN when the fit is not usable.
double fit_error_mm(const Twin& twin, const measure::ObjectFit& fit);

}  // namespace fringetwin::cosim
