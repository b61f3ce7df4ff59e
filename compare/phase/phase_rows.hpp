// SPDX-License-Identifier: Apache-2.0
// Computes the differences of the absolute phase at the finest pitch, simulated - real, as rows of numbers
// and as images.
#pragma once
#include <vector>

#include "compare/result/rows.hpp"
#include "measure/measurement.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// Returns one row per camera and direction that both sides decoded.
std::vector<PhaseRow> phase_rows(const Twin& twin, const measure::Measurement& real,
                                 const measure::Measurement& simulated);

/// Returns 2 pi (x_sim - x_real) / pitch of one camera and direction (indices into both measurements' common
/// directions); NaN where one side is invalid or the fringe orders disagree (farthest_rad()).
ImageF phase_difference(const measure::DirectionDecode& real, const measure::DirectionDecode& simulated);

/// Returns how far two phases of one fringe order may differ: pi, half a fringe. A code alone is read in
/// whole words, of which the neighbours are no other order: 4.5 of them.
double farthest_rad(const measure::DirectionDecode& decode);

/// Returns the projector coordinate at which the decode's finest pitch has phase 0, as the twin says.
double phase_origin_px(const Twin& twin, const measure::DirectionDecode& decode);

/// Returns 2 pi (x - origin) / pitch at the finest pitch.
ImageF absolute_phase(const Twin& twin, const measure::DirectionDecode& decode);

}  // namespace fringetwin::compare
