// SPDX-License-Identifier: Apache-2.0
// A scene for tests of what fringes are made of: one surface, all of it lit, few pixels.
#pragma once
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing {

/// Returns a tilted plane in a window of the left camera around a point, so many steps.
inline Twin tilted_window(int steps, const Eigen::Vector3d& at_mm = {0, 0, 290}) {
  Twin twin = with_object(left_window(at_mm, 80, 60), "plane", tilted_plane());
  twin.fringes.steps = steps;
  return twin;
}

}  // namespace fringetwin::testing
