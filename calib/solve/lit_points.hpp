// SPDX-License-Identifier: Apache-2.0
// Takes the lit points that a projector is solved from out of what two cameras measured.
#pragma once
#include <cstddef>
#include <vector>

#include "calib/solve/projector_from_points.hpp"
#include "measure/measurement.hpp"

namespace fringetwin::calib {

inline constexpr int kTilePx = 64;
/// More say nothing new: neighbours share their errors.
inline constexpr std::size_t kMostLitPoints = 60000;

/// Returns triangulated points with the coordinates that the first camera decoded at their pixels, on a grid
/// as fine as gives at most `most` of them; rows where all cameras decode both directions. The points must
/// come from two cameras: their places then owe nothing to a projector.
std::vector<LitPoint> lit_points(const measure::Measurement& measurement, std::size_t most = kMostLitPoints);

}  // namespace fringetwin::calib
