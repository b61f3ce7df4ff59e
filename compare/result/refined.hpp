// SPDX-License-Identifier: Apache-2.0
// Holds what comes out of a refinement: the changed twin and the report of the fit.
#pragma once
#include <vector>

#include "compare/result/verdict_tables.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// A twin after a refinement, and the report of the fit.
struct Refined {
  Twin twin;
  Refinement report;
  /// The twin changed along each principal direction of the covariance of its places, one standard error far;
  /// empty where no place was fitted.
  std::vector<Twin> one_error_away = {};
};

}  // namespace fringetwin::compare
