// SPDX-License-Identifier: Apache-2.0
// Colours the points of a fit by their distance from the fitted surface, for programs that show PLY files.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "measure/measurement.hpp"

namespace fringetwin::compare {

/// Returns the fit of an object that knows the deviation of each of its points; nullptr without one.
const measure::ObjectFit* fit_with_deviations(const measure::Measurement& measurement,
                                              const std::string& object);

/// Returns the largest of these fits' percentiles of |deviation|, µm: where the colours of all of them end.
double deviation_span_um(const std::vector<const measure::ObjectFit*>& fits, double percent);

/// The colours of maps and points end at this percentile of |deviation|.
inline constexpr double kDeviationPercent = 99.0;

/// Returns "deviation_<object>.ply".
std::string deviation_cloud_name(const std::string& object);

/// Writes DIR/deviation_<object>.ply of each fitted object of a measurement that knows its deviations: the
/// points used, scalar_deviation_mm (signed, positive outside) and red, green, blue from -span (blue) over 0
/// (white) to +span (red). The span is common to all `sides`, which hold the measurement itself.
void write_deviation_clouds(const std::filesystem::path& dir, const measure::Measurement& measurement,
                            const std::vector<const measure::Measurement*>& sides);

}  // namespace fringetwin::compare
