// SPDX-License-Identifier: Apache-2.0
// Chooses the smallest model for a tolerance, from what each effect changes alone.
#pragma once
#include <cstddef>
#include <vector>

namespace fringetwin::tradeoff {

/// What leaving something out changes; NaN = that quantity does not exist for this twin (no phase steps,
/// no fit) and is not judged, +inf = it cannot be compared any more (too large).
struct Change {
  double phase_rad = 0.0, gray_dn = 0.0, fit_mm = 0.0;
};
struct Tolerance {
  double phase_rad = 0.0, gray_dn = 0.0, fit_mm = 0.0;
};
/// True when every quantity that exists is at most its tolerance.
bool within(const Change& change, const Tolerance& tolerance);
/// Returns the tightest of the three: largest change / tolerance. 0 when nothing exists.
double strain(const Change& change, const Tolerance& tolerance);
Change operator+(const Change& a, const Change& b);  ///< NaN only where both are

struct Candidate {
  Change change;
  double cost = 1.0;  ///< time with / time without
};
/// Returns the indices of what to leave off, in the order chosen: dearest first (equal cost: smallest strain
/// first), as long as the changes ADDED UP stay within the tolerance. The sum of rms values bounds the rms of
/// the sum, so for effects that superpose the whole reduced model stays within, too.
std::vector<std::size_t> leave_off(const std::vector<Candidate>& candidates, const Tolerance& tolerance);

}  // namespace fringetwin::tradeoff
