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

std::optional<bool> all_explained(const std::vector<ExplainedRow>& rows, const std::string& quantity) {
  std::optional<bool> all;
  for (const ExplainedRow& row : rows)
    if (row.quantity == quantity) all = all.value_or(true) && row.explained;
  return all;
}

BudgetVerdict VerdictTables::budget_verdict() const {
  const auto of = [this](const char* quantity) -> std::string {
    const std::optional<bool> all = all_explained(explained, quantity);
    return !all ? "" : *all ? "explained" : "not explained";
  };
  return {of("gray"), of("phase"), of("geometry"), of("coverage")};
}

}  // namespace fringetwin::compare
