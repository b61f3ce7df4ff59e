// SPDX-License-Identifier: Apache-2.0
// Which harmonics of the fringes are looked for in phase steps.
#pragma once

namespace fringetwin::measure {

/// Returns the order of the highest harmonic that is looked for with all of so many steps.
constexpr int highest_harmonic_told(int n_steps) {
  constexpr int kMost = 7;
  return n_steps - 2 < kMost ? n_steps - 2 : kMost;
}

}  // namespace fringetwin::measure
