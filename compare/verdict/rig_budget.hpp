// SPDX-License-Identifier: Apache-2.0
// Computes what the uncertain numbers of a rig leave uncertain in gray values, phase and fits: the twin is
// changed along each principal direction of a covariance, rendered, and measured as it is itself
// (docs/metrics/verdict.md, "Calibration in the budget" and "Refined values in the budget").
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

inline constexpr const char* kCalibrationLine = "calibration covariance";
inline constexpr const char* kRefinedLine = "standard errors of the refined places";

/// Variances that the uncertain numbers of a rig make.
struct RigBudget {
  std::string line = kCalibrationLine;  ///< what a verdict's budget calls them
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

/// How the rigs of a budget are rendered and measured.
struct RigBudgetOptions {
  render::Renderer& renderer;
  render::Sampling sampling;
  std::uint64_t seed = 0;
  std::vector<int> use_steps = {};
  /// What the renderer makes of the twin itself so, one per camera; empty: it is rendered.
  const std::vector<CameraImages>& nominal;
};

/// Returns the variances of independent changes, each as large as its standard uncertainty: all cameras of
/// each changed rig are rendered, exposed without noise and rounding, and measured with the twin. `line`: of
/// the result. Throws Cancelled after Ctrl-C.
RigBudget rig_budget(const Twin& twin, const std::vector<Twin>& changed, std::string line,
                     const RigBudgetOptions& options);

/// Returns the budget of all uncertain numbers together; that of a calibration keeps its name.
RigBudget together(RigBudget calibration, const RigBudget& other);

}  // namespace fringetwin::compare
