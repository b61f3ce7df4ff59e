// SPDX-License-Identifier: Apache-2.0
// What the mean over an interval leaves of a wave.
#pragma once
#include <cmath>

namespace fringetwin {

/// Returns sin(x)/x, the mean of a wave's cosine over -x ... x rad of its phase; 1 at 0.
inline double sinc(double x) { return std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x; }

}  // namespace fringetwin
