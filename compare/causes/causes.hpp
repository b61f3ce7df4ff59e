// SPDX-License-Identifier: Apache-2.0
// Takes the samples of all cameras and finds which error of the twin would explain what noise does not: every
// parameter group is fitted to the gray values in one linear step (docs/metrics/causes.md, "Causes").
#pragma once
#include "compare/causes/cause_decision.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Ranks the causes; leaves the rows empty where noise explains the gray values (no excess). `sensitivity`
/// holds the samples of all cameras, `fits` what both sides measured of the objects; `steps`: the phase steps
/// that the samples hold (empty: all), over which factors of light are one in the mean.
Causes find_causes(Sensitivity& sensitivity, const Twin& twin, const std::vector<FitRow>& fits = {},
                   const std::vector<int>& steps = {});

}  // namespace fringetwin::compare
