// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/recommend.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fringetwin::tradeoff {
namespace {

double add_known(double a, double b) { return std::isnan(a) ? b : std::isnan(b) ? a : a + b; }

double ratio(double change, double tolerance) {
  if (std::isnan(change) || change == 0.0) return 0.0;
  return change / tolerance;  // tolerance 0: +inf
}

}  // namespace

bool within(const Change& change, const Tolerance& tolerance) { return strain(change, tolerance) <= 1.0; }

double strain(const Change& change, const Tolerance& tolerance) {
  return std::max({ratio(change.phase_rad, tolerance.phase_rad), ratio(change.gray_dn, tolerance.gray_dn),
                   ratio(change.fit_mm, tolerance.fit_mm)});
}

Change operator+(const Change& a, const Change& b) {
  return {add_known(a.phase_rad, b.phase_rad), add_known(a.gray_dn, b.gray_dn),
          add_known(a.fit_mm, b.fit_mm)};
}

std::vector<std::size_t> leave_off(const std::vector<Candidate>& candidates, const Tolerance& tolerance) {
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    if (candidates[a].cost != candidates[b].cost) return candidates[a].cost > candidates[b].cost;
    return strain(candidates[a].change, tolerance) < strain(candidates[b].change, tolerance);
  });
  std::vector<std::size_t> out;
  Change total;
  for (const std::size_t i : order) {
    const Change with = total + candidates[i].change;
    if (!within(with, tolerance)) continue;
    total = with;
    out.push_back(i);
  }
  return out;
}

}  // namespace fringetwin::tradeoff
