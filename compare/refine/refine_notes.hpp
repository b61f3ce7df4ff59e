// SPDX-License-Identifier: Apache-2.0
// Says in the report of a refinement what its reader must know besides the values.
#pragma once
#include <string>
#include <vector>

#include "compare/causes/group_fit.hpp"
#include "compare/parameters/grid_view.hpp"
#include "compare/result/verdict_tables.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Fills the covariance of the parameters that the images tell, `told` in the order of the fit's, and notes
/// those that are told apart poorly.
void note_correlations(const GroupFit& fit, const std::vector<std::size_t>& told, Refinement& report);

/// Lets the twin name a texture for each camera that was fitted, and notes what is no evidence then.
void note_texture(const std::vector<GridSamples>& samples, Refinement& report, Twin& twin);

/// Notes which image of a code has the most other light, which no key was asked to hold.
void note_light_of_code(const GridSamples& samples, const Twin& twin, std::vector<std::string>& notes);

}  // namespace fringetwin::compare
