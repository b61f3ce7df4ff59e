// SPDX-License-Identifier: Apache-2.0
#include "twin/number/pareto_front.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fringetwin {

std::vector<std::size_t> pareto_front(const std::vector<CostAndError>& points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::isnan(points[i].cost) && !std::isnan(points[i].error)) order.push_back(i);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return points[a].cost != points[b].cost ? points[a].cost < points[b].cost
                                            : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order)
    if (points[i].error < best) {
      best = points[i].error;
      front.push_back(i);
    }
  return front;
}

}  // namespace fringetwin
