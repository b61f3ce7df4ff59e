// SPDX-License-Identifier: Apache-2.0
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

std::optional<bool> all_explained(const std::vector<ExplainedRow>& rows, const std::string& quantity) {
  std::optional<bool> all;
  for (const ExplainedRow& row : rows)
    if (row.quantity == quantity) all = all.value_or(true) && row.explained;
  return all;
}

}  // namespace fringetwin::compare
