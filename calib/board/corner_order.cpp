// SPDX-License-Identifier: Apache-2.0
#include "calib/board/corner_order.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::calib {
namespace {

/// Corners in a wrong order are a spacing and more away, all but a few in the middle of the board.
constexpr double kTogether = 0.25;
/// Two orders cannot be told from fewer corners in common.
constexpr std::size_t kLeastInCommon = 6;

/// Returns the median distance of corners that both have, infinite where they have too few.
double apart_px(const std::vector<Corner>& a, const std::vector<Corner>& b) {
  std::vector<double> distances_px;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].seen() && b[i].seen()) distances_px.push_back((a[i].q_px - b[i].q_px).norm());
  return distances_px.size() < kLeastInCommon ? INFINITY : upper_median(distances_px);
}

/// Returns the median distance of neighbours in a row, 0 where there are none.
double spacing_px(const Board& board, const std::vector<Corner>& corners) {
  const auto width = static_cast<std::size_t>(board.width_n);
  std::vector<double> distances_px;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i)
    if ((i + 1) % width != 0 && corners[i].seen() && corners[i + 1].seen())
      distances_px.push_back((corners[i + 1].q_px - corners[i].q_px).norm());
  return distances_px.empty() ? 0.0 : upper_median(distances_px);
}

}  // namespace

double mirrored_share(const Board& board, const std::vector<Corner>& corners) {
  const auto width = static_cast<std::size_t>(board.width_n);
  int n = 0, n_mirrored = 0;
  for (std::size_t i = 0; i + width + 1 < corners.size(); ++i) {
    if ((i + 1) % width == 0) continue;
    const Corner &a = corners[i], &right = corners[i + 1], &below = corners[i + width],
                 &across = corners[i + width + 1];
    if (!a.seen() || !right.seen() || !below.seen() || !across.seen()) continue;
    const Eigen::Vector2d d = across.q_px - a.q_px, e = below.q_px - right.q_px;
    ++n;
    n_mirrored += d.x() * e.y() - d.y() * e.x() < 0.0;
  }
  constexpr int kFewestCells = 6;
  return n < kFewestCells ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(n_mirrored) / n;
}

std::optional<bool> is_mirrored(const Board& board, const std::vector<Corner>& corners) {
  constexpr double kMostCells = 0.75;
  const double share = mirrored_share(board, corners);
  return std::isnan(share) ? std::nullopt : std::optional(share > kMostCells);
}

const CornerOrder* turn_beside(const Board& board, const std::vector<Corner>& first,
                               const std::vector<Corner>& other) {
  const double together_px = kTogether * spacing_px(board, first);
  if (apart_px(first, other) <= together_px) return nullptr;
  for (const CornerOrder& order : kCornerOrders) {
    if (order.is_mirrored() || (order.transpose && board.width_n != board.height_n)) continue;
    if (apart_px(first, reordered(board, other, order)) <= together_px) return &order;
  }
  return nullptr;
}

void check_not_mirrored(const Observations& o) {
  constexpr double kMostViews = 0.75;
  std::vector<int> n(o.devices.size()), n_mirrored = n;
  for (const View& view : o.views) {
    const std::optional<bool> mirrored = is_mirrored(o.board, view.corners);
    if (!mirrored) continue;
    ++n[view.device];
    n_mirrored[view.device] += *mirrored;
  }
  const auto most_are = [&](std::size_t d) { return n_mirrored[d] > kMostViews * n[d]; };
  bool others_are_not = false;
  for (std::size_t d = 0; d < n.size(); ++d) others_are_not = others_are_not || (n[d] > 0 && !most_are(d));
  for (std::size_t d = 0; d < n.size(); ++d)
    if (most_are(d) && others_are_not)
      throw UserError(
          ExitCode::input, (o.file.empty() ? "" : o.file.string() + ": ") + o.devices[d].name,
          fmt::format("{} of its {} views have the corners as in a mirror", n_mirrored[d], n[d]),
          "are its images mirrored, or the rows of its corners from right to left? Of a projector: are the "
          "fringes of x and y exchanged, the cameras' images mirrored, or is it set to rear projection?");
}

}  // namespace fringetwin::calib
