// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/overall.hpp"

#include <utility>

namespace fringetwin::compare {
namespace {

/// Returns the worst state with the quantities that are in it, "explained" alone where all are; empty without
/// any.
std::string explanation(const BudgetVerdict& v) {
  const std::pair<const char*, const std::string&> quantities[] = {{"coverage", v.coverage},
                                                                   {"phase", v.phase},
                                                                   {"gray", v.gray},
                                                                   {"code", v.code},
                                                                   {"geometry", v.geometry}};
  std::string worst, names;
  for (const auto& [name, state] : quantities) worst = worse_state(worst, state);
  if (worst.empty() || worst == kExplained) return worst;
  for (const auto& [name, state] : quantities)
    if (state == worst) names += (names.empty() ? "" : ", ") + std::string(name);
  return names + ": " + worst;
}

}  // namespace

OverallVerdict overall_verdict(const Comparison& comparison) {
  const std::string budget = explanation(comparison.budget_verdict());
  const bool limits = !comparison.limits.empty();
  const char* met = !limits ? "no limits set" : comparison.pass ? "limits met" : "limits not met";
  const bool nothing_against = budget.empty() || budget == kExplained;
  return {budget.empty() ? met : budget + "; " + met, limits && !comparison.pass  ? "fail"
                                                      : limits && nothing_against ? "pass"
                                                                                  : "none"};
}

}  // namespace fringetwin::compare
