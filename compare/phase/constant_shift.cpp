// SPDX-License-Identifier: Apache-2.0
#include "compare/phase/constant_shift.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {
constexpr std::size_t kFewestPoints = 200;
constexpr double kLeastPeriods = 0.2;    ///< less may well be a displaced surface, which refinement finds
constexpr double kSpreadPeriods = 0.05;  ///< a surface displaced in depth shifts its fringes less evenly
constexpr double kLeastAlike = 0.95;
}  // namespace

std::optional<double> constant_shift_px(const measure::DirectionDecode& real,
                                        const measure::DirectionDecode& simulated) {
  std::vector<double> shifts_px;
  for (std::size_t i = 0; i < real.coordinate_px.size(); ++i)
    if (const double shift_px = real.coordinate_px.data[i] - simulated.coordinate_px.data[i];
        !std::isnan(shift_px))
      shifts_px.push_back(shift_px);
  if (shifts_px.size() < kFewestPoints) return std::nullopt;
  const double pitch_px = real.pitches_px[real.finest], middle_px = median(shifts_px);
  const auto alike = std::ranges::count_if(shifts_px, [&](double shift_px) {
    return std::abs(shift_px - middle_px) <= kSpreadPeriods * pitch_px;
  });
  if (std::abs(middle_px) < kLeastPeriods * pitch_px ||
      static_cast<double>(alike) < kLeastAlike * static_cast<double>(shifts_px.size()))
    return std::nullopt;
  return middle_px;
}

}  // namespace fringetwin::compare
