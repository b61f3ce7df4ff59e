// SPDX-License-Identifier: Apache-2.0
// Fits of both sides next to each other (the paper's Table 5).
#pragma once
#include <string>
#include <vector>

#include "compare/comparison.hpp"

namespace fringetwin::compare {

/// "radius_mm" -> "radius_sigma_mm", "normal" -> "normal_sigma".
std::string sigma_key(const std::string& key);
/// True for keys that are standard errors themselves.
bool is_sigma_key(const std::string& key);

/// True for keys that count things ("n_gated"): neither lengths nor angles, nothing to subtract.
bool is_count_key(const std::string& key);

/// A published result as a fit row: n = 0, the kind of the twin's object.
measure::ObjectFit published_fit(const Twin& twin, const PublishedFit& published);

/// simulated - real for every number both sides have; z = difference / sqrt(sigma_s^2 + sigma_r^2),
/// absent (vectors: NaN elements) where a sigma is unknown. Planes: also offset_mm (distance of the
/// simulated point from the real plane) and angle_rad; cylinders: axis_distance_mm and angle_rad.
FitRow make_fit_row(const std::optional<measure::ObjectFit>& simulated,
                    const std::optional<measure::ObjectFit>& real);

/// One row per object, in the order of twin.measure.fits, then whatever else a side has.
/// Published numbers (twin.real.results) stand in where the real side was not measured.
std::vector<FitRow> fit_rows(const Twin& twin, const Side& real, const Side& simulated,
                             std::vector<std::string>& warnings);

}  // namespace fringetwin::compare
