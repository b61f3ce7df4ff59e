// SPDX-License-Identifier: Apache-2.0
// Finds where the real images show another surface than the twin: both sides' phases and points go in, a row
// for each connected area comes out (docs/metrics/verdict.md, "Other surfaces").
#pragma once
#include <vector>

#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns the areas of every camera that both sides measured, those of a camera by their size. None of a
/// camera most of whose pixels have other fringe orders: other fringes were shown than described. None where
/// an object is itself made from the real capture.
std::vector<OtherSurfaceRow> other_surfaces(const Twin& twin, const Side& real, const Side& simulated);

/// Holds the areas against the verdicts on the coverage of their cameras, and on the phases that have other
/// fringe orders there, which are in no number of the phase.
void hold_against_surfaces(const std::vector<OtherSurfaceRow>& surfaces, std::vector<ExplainedRow>& rows);

}  // namespace fringetwin::compare
