// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/overall.hpp"

#include <utility>

namespace fringetwin::compare {
namespace {

/// Returns the worst state with the quantities that are in it, "explained" alone where all are; empty without
/// any.
std::string explanation(const BudgetVerdict& v) {
  const std::pair<const char*, const std::string&> quantities[] = {
      {"coverage", v.coverage}, {"phase", v.phase}, {"gray", v.gray}, {"geometry", v.geometry}};
  for (const char* state : {kNotExplained, kNotCompared, kTooWide}) {
    std::string names;
    for (const auto& [name, its_state] : quantities)
      if (its_state == state) names += (names.empty() ? "" : ", ") + std::string(name);
    if (!names.empty()) return names + ": " + state;
  }
  for (const auto& [name, its_state] : quantities)
    if (its_state == kExplained) return kExplained;
  return "";
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
