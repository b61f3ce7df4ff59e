// SPDX-License-Identifier: Apache-2.0
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

std::vector<BudgetShare> ExplainedRow::shares() const {
  std::vector<BudgetShare> out;
  for (const BudgetLine& line : lines) out.push_back({line.name, line.variance, line.variance / expected()});
  return out;
}

std::vector<std::vector<double>> Refinement::covariance_rows() const {
  std::vector<std::vector<double>> out;
  for (const auto& row : covariance.rowwise()) out.emplace_back(row.begin(), row.end());
  return out;
}

std::string worse_state(const std::string& a, const std::string& b) {
  for (const char* state : {kNotExplained, kNotCompared, kTooWide, kExplained})
    if (a == state || b == state) return state;
  return "";
}

void ExplainedRow::worsen(const char* to, const std::string& because) {
  state = worse_state(state, to);
  if (!because.empty()) why += (why.empty() ? "" : "; ") + because;
}

std::string worst_state(const std::vector<ExplainedRow>& rows, const std::string& quantity) {
  std::string worst;
  for (const ExplainedRow& row : rows)
    if (row.quantity == quantity) worst = worse_state(worst, row.state);
  return worst;
}

BudgetVerdict VerdictTables::budget_verdict() const {
  return {worst_state(explained, "gray"), worst_state(explained, "phase"), worst_state(explained, "geometry"),
          worst_state(explained, "coverage"), worst_state(explained, "code")};
}

}  // namespace fringetwin::compare
