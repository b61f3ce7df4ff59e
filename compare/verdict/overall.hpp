// SPDX-License-Identifier: Apache-2.0
// Sums a comparison up in one line, for the badge of the page and the end of a run: the worst that the budget
// says of any quantity, then the limits.
#pragma once
#include <string>

#include "compare/result/rows.hpp"

namespace fringetwin::compare {

struct OverallVerdict {
  /// "phase, coverage: not explained; limits met", "explained; no limits set", "limits not met" (nothing to
  /// explain).
  std::string text;
  /// "fail" where a limit is not met; "pass" where limits are set and met and nothing speaks against; else
  /// "none".
  std::string badge;
};
OverallVerdict overall_verdict(const Comparison& comparison);

}  // namespace fringetwin::compare
