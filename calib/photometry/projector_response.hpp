// SPDX-License-Identifier: Apache-2.0
// Estimates the projector's response and blur from the harmonics of its fringes.
#pragma once
#include <vector>

#include "calib/photometry/fringe_harmonics.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib {

/// Contrast of one order at one pitch relative to the same order at the coarsest pitch.
struct MtfPoint {
  double period_px = 0.0;  ///< pitch / order, projector px
  double pitch_px = 0.0;
  int order = 1;
  Estimate contrast = {};      ///< as the camera sees it
  double camera_factor = 1.0;  ///< of it, what the camera's pixel area (and known psf) takes
  double gaussian = 1.0;       ///< what the fitted blur_px gives
};

struct ProjectorPhotometry {
  FringeHarmonics harmonics;
  std::vector<MtfPoint> mtf;
  Estimate blur_px;          ///< Gaussian sigma; NaN with one pitch
  double blur_misfit = 0.0;  ///< rms of ln(contrast) about the Gaussian: far above 0.02, it is none
  double blur_of_twin_px = 0.0;
  /// Returns whether the blur is told from none, or from the twin's: their squares, which are what contrasts
  /// tell, differ by three standard errors (of the square: 2 blur sigma, and sigma^2 near none) or more.
  bool tells_blur() const;

  /// Harmonics of the light before blur and camera, order 2..., relative to order 1 (index 0: order 2).
  std::vector<Estimate> response_harmonics;
  Estimate gamma;             ///< NaN with N = 3 steps
  double gamma_misfit = 0.0;  ///< rms difference of the two curves, fraction of the range of the light
  /// The light at equally spaced levels of the projected range, 0 at its low and 1 at its high end, and its
  /// sigma; from the Chebyshev series of the harmonics. Empty with fewer than 3 orders.
  std::vector<double> curve_level, curve_light, curve_sigma;
  /// The response to be written into [projector].
  ProjectorResponse response;
  bool response_known = false;
};

/// Light as a function of the pattern's value v = mean + amplitude cos(theta) is even in theta, hence
/// sum_h r_h cos(h theta) = sum_h r_h T_h((v - mean)/amplitude). Blur and pixel area are divided out
/// with the Gaussian and the camera factor. A gamma is written when it describes the curve to 0.01, else a
/// table (only where the fringes cover 0...1); "linear" when gamma is 1 within two sigmas or 0.01.
ProjectorPhotometry projector_photometry(FringeHarmonics harmonics, double mean, double amplitude);

/// Harmonics 1...n of (mean + amplitude cos theta)^gamma.
std::vector<double> gamma_harmonics(double gamma, double mean, double amplitude, int n);

}  // namespace fringetwin::calib
