// SPDX-License-Identifier: Apache-2.0
// What the fringe's harmonics leave in a second difference along stripes that are not quite straight.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "measure/decode/phase.hpp"
#include "twin/fringes.hpp"
#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::measure {

/// One pitch of one direction as the estimator of noise sees it.
struct NoiseInput {
  std::vector<const GrayImage*> steps;
  const ImageF* phase = nullptr;  ///< NaN where masked
  const ImageF* amplitude = nullptr;
};

/// Harmonics 2 to 6 of one pitch's fringe in the contrasts of its steps: the contrast j of a pixel of phase p
/// and amplitude a is a sum_k (alpha_kj cos k p + beta_kj sin k p), with the same alpha and beta for all
/// pixels, since a projector's response makes its harmonics before anything reflects them. Where the phase
/// turns by s from pixel to pixel along the stripes, the second difference over sqrt(6) of the k-th is
/// -(4 / sqrt(6)) sin^2(k s / 2) times its value.
class StripeHarmonics {
 public:
  /// Fits alpha and beta to every `stride`-th lit pixel (a phase, and `min_amplitude`) each way by least
  /// squares; `contrasts` is N x (N - 3). They are zero where too few phases are seen.
  StripeHarmonics(const NoiseInput& in, const Eigen::MatrixXd& contrasts, Axis axis, int stride,
                  double min_amplitude);

  /// Returns whether any harmonic is large enough to be seen beside noise.
  bool matter() const;
  /// Returns what the harmonics leave in the second difference of each contrast about a lit pixel.
  Eigen::VectorXd remainder(int x, int y) const;

 private:
  bool is_lit(int x, int y) const;
  double turn_per_px(int x, int y) const;
  const NoiseInput& in_;
  Axis axis_;
  double min_amplitude_;
  Eigen::MatrixXd coefficients_;  ///< alpha and beta of 2, 3, ... x (N - 3)
};

}  // namespace fringetwin::measure
