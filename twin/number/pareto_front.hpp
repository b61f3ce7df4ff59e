// SPDX-License-Identifier: Apache-2.0
// Of many choices with a cost and an error, finds those that no other choice beats in both.
#pragma once
#include <cstddef>
#include <vector>

namespace fringetwin {

struct CostAndError {
  double cost = 0.0, error = 0.0;  ///< NaN in either: takes no part
};
/// Returns the indices of the points with no other point at most as costly and at most as wrong and better in
/// one of the two; by rising cost, so by falling error. Of equal points the first is kept.
std::vector<std::size_t> pareto_front(const std::vector<CostAndError>& points);

}  // namespace fringetwin
