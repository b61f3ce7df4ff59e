// SPDX-License-Identifier: Apache-2.0
// Estimates the harmonics of projected fringes as a camera sees them: the N phase-step images of every pitch
// of one direction go in, the strength of each harmonic relative to the coarsest pitch's fundamental comes
// out, and with it the factor by which the camera's pixels blur it.
#pragma once
#include <cstddef>
#include <vector>

#include "calib/photometry/photon_transfer.hpp"
#include "twin/fringes.hpp"
#include "twin/image/gray_image.hpp"

namespace fringetwin::calib {

/// Holds the harmonics at one pitch: index h-1 holds order h, for the orders 1...N/2.
struct PitchHarmonics {
  double pitch_px = 0.0;
  /// Median over the pixels of |2/N sum_n I_n exp(-2 pi i h n/N)|: noise is in it (it alone makes about
  /// 1.18 sigma sqrt(2/N)).
  std::vector<double> median_dn;
  /// The part in phase with the pitch's own fundamental, as a fraction of the fundamental at the reference
  /// pitch, weighted by its square: noise averages out. Negative where it is in antiphase.
  std::vector<Estimate> amplitude;
  /// The part 90 degrees out of phase: 0 unless the steps are unequal or something moved (order 1: 0).
  std::vector<Estimate> quadrature;
  /// Mean factor by which the camera's pixel area and known point spread lower the order.
  std::vector<double> camera_factor;
};

struct FringeHarmonics {
  Axis axis = Axis::x;
  int steps = 0;
  int reference = 0;                           ///< index of the coarsest pitch
  std::size_t n = 0;                           ///< pixels: modulated enough and not saturated at any pitch
  double mean_dn = 0.0, fundamental_dn = 0.0;  ///< medians at the reference pitch
  std::vector<PitchHarmonics> pitches = {};    ///< in sequence order
};

struct HarmonicsOptions {
  double min_modulation_dn = 5.0, saturation_dn = 255.0;
  double pixel_fill = 1.0;  ///< side of the camera pixel's light-sensitive square, in pixels
  double psf_px = 0.0;      ///< sigma of the camera lens's Gaussian blur; 0 when the twin has none
};

/// Estimates the harmonics from steps[pitch][n], all N >= 3 phase steps of one direction. Standard errors
/// come from a jackknife over image blocks. Orders above N/2 cannot be told apart: order N - h adds to order
/// h. The result has n = 0 when no pixel can be used.
FringeHarmonics fringe_harmonics(const std::vector<std::vector<const GrayImage*>>& steps,
                                 const DirectionFringes& fringes, const HarmonicsOptions& options);

}  // namespace fringetwin::calib
