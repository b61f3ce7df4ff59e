// SPDX-License-Identifier: Apache-2.0
// Computes what the covariance of the calibration leaves uncertain in gray values, phase and fits: the rig is
// changed along each of its principal directions, rendered, and measured with the nominal twin
// (docs/metrics/verdict.md, "Calibration in the budget").
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "compare/verdict/calibration_covariance.hpp"
#include "render/renderer.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// Variances that the calibration's covariance makes.
struct CalibrationBudget {
  /// Per camera and pixel: variance of the irradiance, mean over the phase steps.
  std::vector<ImageF> irradiance;
  /// Per camera and direction: variance of the phase at the finest pitch, rad^2.
  std::vector<std::vector<ImageF>> phase_rad2;
  /// Per fitted object: variances, keys as in FitRow::difference and ::difference_vectors.
  struct Fit {
    std::map<std::string, double> numbers;
    std::map<std::string, Eigen::Vector3d> vectors;
  };
  std::map<std::string, Fit> fits;
  std::vector<std::string> warnings;
  int n_directions = 0;
};

/// Renders and measures all cameras of the rig changed along each direction, from exposures without noise and
/// rounding. `nominal`: what the renderer makes of the twin itself with this sampling and seed, one per
/// camera; empty: it is rendered here. Throws Cancelled after Ctrl-C.
CalibrationBudget calibration_budget(const Twin& twin, const CalibrationCovariance& covariance,
                                     render::Renderer& renderer, const render::Sampling& sampling,
                                     std::uint64_t seed, const std::vector<int>& use_steps,
                                     const std::vector<CameraImages>& nominal = {});

}  // namespace fringetwin::compare
