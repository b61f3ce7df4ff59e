// SPDX-License-Identifier: Apache-2.0
// A groove before a small camera and a projector, for light between surfaces, and how far a trace of it is
// from the reference.
#pragma once
#include <cmath>
#include <vector>

#include "tests/support/agreement.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

constexpr double kApexMm = 330.0, kWallMm = 40.0;

/// A camera of 160 x 120 px at the origin and a projector beside it that looks at the same point.
Twin rig_before(double distance_mm);

/// Two walls at right angles that meet along y at z = kApexMm, open towards the camera: "left_wall" (below x
/// = 0) and "right_wall".
Twin groove(double diffuse, double length_mm = 60.0);

/// Errors of values relative to their truths, in their mean and rms.
struct Errors {
  double sum = 0.0, sum_sq = 0.0;
  int n = 0;
  void add(double error) {
    sum += error;
    sum_sq += error * error;
    ++n;
  }
  double mean() const { return sum / n; }
  double rms() const { return std::sqrt(sum_sq / n); }
};

/// How far a trace is from the reference: phase of the finest fringes, and the mean of all patterns.
struct Differences {
  Errors phase_rad, gray;  ///< gray: of full scale
};

Differences differences(const Twin& twin, const render::Transport& found,
                        const std::vector<ReferenceBlockPixel>& truth);

}  // namespace fringetwin::testing
