// SPDX-License-Identifier: Apache-2.0
// Noise of the real images against the noise the twin's sensor predicts: the numbers (docs/METRICS.md,
// "Noise").
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// Gray noise of one interval of gray levels.
struct NoiseLevel {
  double level_dn = 0, measured_dn = 0, predicted_dn = 0;
  std::uint64_t n = 0;
};

/// One camera and direction. Ratios are measured / predicted standard deviations, each value against its own
/// prediction.
struct NoiseRow {
  std::string camera, direction;
  bool sensor_known =
      false;      ///< false: the twin's sensor has no noise, so only its rounding is the prediction
  int steps = 0;  ///< N: the residuals of one pixel have N - 3 degrees of freedom
  double gray_measured_dn = 0, gray_predicted_dn = 0, gray_ratio = 0, gray_ratio_sigma = 0;
  std::uint64_t n = 0;
  double phase_measured_rad = 0, phase_predicted_rad = 0, phase_ratio = 0, phase_ratio_sigma = 0;
  std::uint64_t n_phase = 0;

  // for the page only
  std::vector<NoiseLevel> levels;
  ImageF ratio_map;  ///< gray ratio of blocks of kNoiseBlock px; NaN where too few values
  /// Quantiles of the residuals over their predicted sigma against those of the normal distribution.
  std::vector<double> normal_quantile, residual_quantile;
};

inline constexpr int kNoiseBlock = 24;

}  // namespace fringetwin::compare
