// SPDX-License-Identifier: Apache-2.0
// What the theory of phase shifting expects of a fit's noise: a closed form per pixel, summed over the pixels
// that see the object; nothing is rendered, decoded or fitted (docs/metrics/study.md, "Theory of the noise").
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <string>

#include "study/plan/study_point.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {

struct NoiseTheory {
  double n = 0.0;        ///< points expected on the object; without any the others are NaN
  double rms_mm = kNan;  ///< of the points' distances from the surface: noise and rounding
  /// Standard deviations over repeated captures. Sphere: centre (world frame) and radius; plane: offset along
  /// the normal at the centroid of the points. NaN for the other shape.
  Eigen::Vector3d center_sigma_mm = Eigen::Vector3d::Constant(kNan);
  double radius_sigma_mm = kNan, offset_sigma_mm = kNan;
};

/// For a sphere or plane alone in the scene, phase shifting of four or more steps in one direction, a linear
/// projector response and sharp lenses. Throws UserError(usage) naming what another twin has that is not in
/// the theory. `most_pixels`: the image is thinned to about that many.
NoiseTheory noise_theory(const Twin& twin, const std::string& object, std::size_t most_pixels = 40'000);

}  // namespace fringetwin::study
