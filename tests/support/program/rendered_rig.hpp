// SPDX-License-Identifier: Apache-2.0
// `calibrate --twin` on rendered boards, held against the rig that was rendered.
//
// | check                 | tolerance   | origin                                              |
// |-----------------------|-------------|-----------------------------------------------------|
// | 36 parameters jointly | chi2 < 64.1 | 99.73 % (3 sigma) of 36 degrees of freedom          |
// | each of them          | 3.96 sigma  | one of 36 beyond in 0.27 % of rigs                  |
// | sigma / bound         | 0.5 … 2     | Cramér-Rao for the corners' noise (rendered_rig.cpp) |
#pragma once
#include "tests/support/program/rendered_boards.hpp"

namespace fringetwin::testing {

/// rms (px per coordinate) of the corners found against the truth.
struct CornerLimits {
  double camera_px, projector_px;
};
void expect_the_rig_is_found(const RenderedBoards& scene, const CornerLimits& limits);

}  // namespace fringetwin::testing
