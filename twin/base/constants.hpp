// SPDX-License-Identifier: Apache-2.0
// Defines the constants that several of the project's folders need: 2 pi, a quiet NaN, the variance of
// rounding.
#pragma once
#include <limits>
#include <numbers>

namespace fringetwin {

inline constexpr double kTwoPi = 2.0 * std::numbers::pi;
inline constexpr double kPerCycle = 1.0 / kTwoPi;  ///< rad -> cycles
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kRoundingVariance = 1.0 / 12.0;  ///< that rounding to integers adds to a value

}  // namespace fringetwin
