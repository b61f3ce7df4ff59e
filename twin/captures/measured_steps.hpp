// SPDX-License-Identifier: Apache-2.0
// Tells which phase steps a measured object is built from, and which are left to compare it with.
#pragma once
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin {

/// Returns the step numbers that `shape` is built from. Throws UserError(usage), naming `object`, for fewer
/// than 3.
std::vector<int> built_from_steps(const Twin& twin, const Object& object, const MeasuredShape& shape);

/// Returns the steps that no measured object is built from: the ones a comparison may use. Empty when there
/// is no measured object, or when they say "all". Throws UserError(usage) where fewer than 3 would be left (a
/// phase needs 3), so also for objects of which one takes the even and one the odd steps.
std::vector<int> left_over_steps(const Twin& twin);

}  // namespace fringetwin
