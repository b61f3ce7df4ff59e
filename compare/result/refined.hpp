// SPDX-License-Identifier: Apache-2.0
// Holds what comes out of a refinement: the changed twin and the report of the fit.
#pragma once
#include "compare/result/verdict_tables.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// A twin after a refinement, and the report of the fit.
struct Refined {
  Twin twin;
  Refinement report;
};

}  // namespace fringetwin::compare
