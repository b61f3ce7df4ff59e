// SPDX-License-Identifier: Apache-2.0
// Counts the pixels that both sides, one side, or neither side measured, and why, and judges whether that is
// no more than outlines and noise make (docs/metrics/verdict.md, "Coverage").
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// What a pixel of one side is.
enum class PixelState : unsigned char { measured, saturated, order, low_modulation, dark };

/// Returns the state of every pixel of one camera that this side measured. Dark: too dark on average for
/// fringes of the modulation that the twin asks for.
Image<PixelState> pixel_states(const Twin& twin, std::size_t camera, const Side& side);

/// Returns a row for each camera that both sides measured, then one for each object that it sees, and one for
/// real points near no object where there are many. Nothing where a side was not measured.
std::vector<CoverageRow> coverage_rows(const Twin& twin, const Side& real, const Side& simulated);

/// Returns a row of the verdict for each camera, explained when its rows of all objects are, and one "not
/// compared" for each object to fit of which nobody measured more than a few pixels.
std::vector<ExplainedRow> explain_coverage(const Twin& twin, const std::vector<CoverageRow>& rows);

/// Returns the sentences that a reader must see: of each camera that is not explained; of its objects where
/// they tell more than the camera's own row. Nothing of areas that `told` says by itself.
std::vector<std::string> coverage_warnings(const std::vector<CoverageRow>& rows,
                                           const std::vector<OtherSurfaceRow>& told = {});

/// The name of the row of points that are near no object of the twin.
inline constexpr const char* kNotInTheTwin = "not in the twin";

}  // namespace fringetwin::compare
