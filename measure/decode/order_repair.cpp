// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/order_repair.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "measure/decode/phase.hpp"
#include "measure/decode/unwrap.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

/// Returns the pixels with a 4-neighbour more than half a period away, by row.
std::vector<std::vector<int>> find_candidates(const ImageD& x_px, double half_period) {
  const int w = x_px.width, h = x_px.height;
  std::vector<std::vector<int>> candidates(h);
#pragma omp parallel for schedule(static) if (h > kSerialRows)
  for (int y = 0; y < h; ++y) {
    const double* row = &x_px(0, y);
    const double* above = y > 0 ? row - w : row;
    const double* below = y + 1 < h ? row + w : row;
    auto& found = candidates[y];
    for (int x = 0; x < w; ++x) {
      const double v = row[x];
      const double left = row[x > 0 ? x - 1 : x], right = row[x + 1 < w ? x + 1 : x];
      if (std::fabs(v - left) > half_period || std::fabs(v - right) > half_period ||
          std::fabs(v - above[x]) > half_period || std::fabs(v - below[x]) > half_period)
        found.push_back(x);
    }
  }
  return candidates;
}

/// Returns the median of the valid pixels around (x, y), itself left out; nullopt without a clear majority.
std::optional<double> local_majority(const ImageD& x_px, int x, int y, const OrderRepairOptions& o) {
  double values[121] = {};
  int n = 0;
  const int r = std::min(o.radius_px, 5);
  for (int v = std::max(0, y - r); v <= std::min(x_px.height - 1, y + r); ++v)
    for (int u = std::max(0, x - r); u <= std::min(x_px.width - 1, x + r); ++u)
      if ((u != x || v != y) && std::isfinite(x_px(u, v))) values[n++] = x_px(u, v);
  if (n < o.min_support) return std::nullopt;
  const double median = upper_median(std::span(values, static_cast<std::size_t>(n)));
  const auto agree =
      std::count_if(values, values + n, [&](double v) { return std::fabs(v - median) < 0.5 * o.period_px; });
  if (static_cast<double>(agree) < o.majority * n) return std::nullopt;
  return median;
}

/// Returns the coordinate one period up or down (across the ends of a cyclic code, too), if the jump is
/// nearly that.
std::optional<double> shift_one_period(double x_px, double predicted_px, const OrderRepairOptions& o) {
  const double periods = (predicted_px - x_px) / o.period_px;
  const double whole = round_even(periods);
  const double steps = o.cycle_px > 0.0 ? std::remainder(whole, std::round(o.cycle_px / o.period_px)) : whole;
  if (std::fabs(steps) != 1.0 || std::fabs(periods - whole) >= o.near) return std::nullopt;
  return x_px + whole * o.period_px;
}

std::optional<double> repaired_value(const ImageD& x_px, int x, int y, const OrderRepairOptions& o) {
  const double value = x_px(x, y);
  const auto majority = local_majority(x_px, x, y, o);
  if (!majority || std::fabs(value - *majority) <= 0.5 * o.period_px) return std::nullopt;
  if (!o.resolve) return shift_one_period(value, *majority, o);
  const auto resolved = o.resolve(x_px.index(x, y), *majority);
  if (!resolved || std::fabs(*resolved - *majority) >= o.near * o.period_px) return std::nullopt;
  return resolved;
}

struct Change {
  std::size_t index;
  double old_px, new_px;
};

/// Decides on the unchanged map, then applies: the order of the pixels plays no part.
std::vector<Change> one_pass(const ImageD& x_px, const OrderRepairOptions& o) {
  const auto candidates = find_candidates(x_px, 0.5 * o.period_px);
  std::vector<std::vector<Change>> per_row(candidates.size());
#pragma omp parallel for schedule(dynamic, 16) if (x_px.height > kSerialRows)
  for (int y = 0; y < x_px.height; ++y)
    for (const int x : candidates[y])
      if (const auto value = repaired_value(x_px, x, y, o))
        per_row[y].push_back({x_px.index(x, y), x_px(x, y), *value});
  std::vector<Change> all;
  for (auto& row : per_row) all.insert(all.end(), row.begin(), row.end());
  return all;
}

/// Returns the number of 4-neighbour pairs that differ by one period or more, up to `near` of a whole one:
/// order errors rather than depth steps, which differ by anything.
std::uint64_t count_order_jumps(const ImageD& coordinate_px, double period_px, double near) {
  const int w = coordinate_px.width, h = coordinate_px.height;
  const auto is_jump = [&](double a, double b) {
    const double periods = (a - b) / period_px, whole = round_even(periods);
    return std::fabs(whole) >= 1.0 && std::fabs(periods - whole) < near;
  };
  std::uint64_t count = 0;
#pragma omp parallel for schedule(static) reduction(+ : count) if (h > kSerialRows)
  for (int y = 0; y < h; ++y) {
    const double* row = &coordinate_px(0, y);
    for (int x = 0; x + 1 < w; ++x) count += is_jump(row[x], row[x + 1]) ? 1u : 0u;
    if (y + 1 == h) continue;
    const double* below = row + w;
    for (int x = 0; x < w; ++x) count += is_jump(row[x], below[x]) ? 1u : 0u;
  }
  return count;
}

}  // namespace

OrderRepair repair_orders(ImageD& coordinate_px, const OrderRepairOptions& options) {
  OrderRepair report;
  for (const double v : coordinate_px.data) report.n_checked += std::isfinite(v) ? 1u : 0u;
  std::vector<std::size_t> changed;
  for (int pass = 0; pass < options.max_passes; ++pass) {
    const std::vector<Change> changes = one_pass(coordinate_px, options);
    if (changes.empty()) break;
    for (const Change& c : changes) {
      coordinate_px.data[c.index] = c.new_px;
      changed.push_back(c.index);
    }
  }
  std::ranges::sort(changed);  // a pixel moved in two passes counts once
  report.n_changed =
      static_cast<std::uint64_t>(std::unique(changed.begin(), changed.end()) - changed.begin());
  report.n_left = count_order_jumps(coordinate_px, options.period_px, options.near);
  return report;
}

}  // namespace fringetwin::measure
