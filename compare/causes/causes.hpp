// SPDX-License-Identifier: Apache-2.0
// Which error of the twin would explain what noise does not: every parameter group is fitted to the gray
// values in one linear step (docs/metrics/causes.md, "Causes").
#pragma once
#include "compare/causes/sensitivity.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Empty rows where noise explains the gray values (no excess). `sensitivity` holds the samples of all
/// cameras.
Causes find_causes(Sensitivity& sensitivity, const Twin& twin);

/// One sentence: "lens distortion explains 99 % of ...", or that none of those tested does.
std::string sentence(const Causes& causes);

}  // namespace fringetwin::compare
