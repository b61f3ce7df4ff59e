// SPDX-License-Identifier: Apache-2.0
// Says what the fitted gain and black level of each camera are worth, from what parts of the gray values
// disagree by and from the verdict on the gray differences (docs/metrics/gray.md, "Gain").
#pragma once
#include <vector>

#include "compare/result/own_kinds.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Fills state, bias and reason of every gain that was fitted and has no state yet, once the rows of
/// `explained` are final; adds a warning for each that is no sensor value. `own`: of each row of `gain`, what
/// every pixel of the simulated side has of its own; with any the line was held for it, and is none.
void trust_gains(Comparison& comparison, const std::vector<OwnKinds>& own = {});

}  // namespace fringetwin::compare
