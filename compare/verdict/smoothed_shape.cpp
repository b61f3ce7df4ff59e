// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/smoothed_shape.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fringetwin::compare {
namespace {

constexpr double kMost = 0.5;  ///< of what regions differ by
/// Of the regions' chi2: what other windows tell is about as large as what smoothing has changed, at creases
/// half of it; four times is another error besides.
constexpr double kMuchMore = 16.0;
constexpr double kSmallWindow = 2.5;  ///< px: smaller ones leave hardly a quadratic, and most of the noise

/// Returns whether a row fails by something else than coverage or smoothing.
bool fails_otherwise(const ExplainedRow& row) {
  return row.state == kNotExplained && row.quantity != "coverage" && !is_smoothed(row);
}

}  // namespace

bool is_smoothed(const ExplainedRow& row) {
  return row.quantity == "gray" && row.state == kNotExplained && row.regional_chi2 > row.regional_limit &&
         row.regional_chi2 < kMuchMore && row.smoothed_fraction > kMost;
}

bool doubt_smoothing(const ShapeNoise* noise, std::vector<ExplainedRow>& rows,
                     std::vector<std::string>& warnings) {
  if (!noise || std::ranges::none_of(rows, is_smoothed)) return false;
  const double radius_px = noise->surface.radius_px;
  const bool can_be_smaller = radius_px > kSmallWindow, is_all = std::ranges::none_of(rows, fails_otherwise);
  for (ExplainedRow& row : rows) {
    if (!is_smoothed(row)) continue;
    row.worsen(
        kNotExplained,
        fmt::format(
            "{:.0f} % of what regions differ by beside noise goes with what the windows of "
            "the measured shape ({:.2g} px) smooth away of its form, as windows of another size tell it: {}",
            100.0 * row.smoothed_fraction, radius_px,
            can_be_smaller ? "measure it with smaller ones (smoothing_px, most_smoothing_px)"
                           : "what is finer than they tell, a factor per pixel takes"));
  }
  if (!is_all || !can_be_smaller) return false;
  warnings.emplace_back(
      "no cause is looked for: the windows of the measured shape smooth away what the gray values show (see "
      "their verdict)");
  return true;
}

}  // namespace fringetwin::compare
