// SPDX-License-Identifier: Apache-2.0
// Pairs the fits of both sides, or published numbers in place of the real ones: one row per object with the
// difference and its z (the paper's Table 5).
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

/// Returns a published result as a fit: n = 0, the kind of the twin's object.
measure::ObjectFit published_fit(const Twin& twin, const PublishedFit& published);

/// Returns simulated - real for every number both sides have; z = difference / sqrt(sigma_s^2 + sigma_r^2),
/// absent (vectors: NaN elements) where a sigma is unknown. Planes: also offset_mm (distance of the
/// simulated point from the real plane), angle_rad and tilt_rad_0, _1; cylinders: axis_distance_mm,
/// angle_rad, axis_rad_0, _1 and axis_shift_mm_0, _1; both along the simulated fit's tilt_direction_0, _1.
FitRow make_fit_row(const std::optional<measure::ObjectFit>& simulated,
                    const std::optional<measure::ObjectFit>& real);

/// Returns one row per object, in the order of twin.measure.fits, then whatever else a side has.
/// Published numbers (twin.real.results) stand in where the real side was not measured.
std::vector<FitRow> fit_rows(const Twin& twin, const Side& real, const Side& simulated,
                             std::vector<std::string>& warnings);

}  // namespace fringetwin::compare
