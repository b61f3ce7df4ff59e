// SPDX-License-Identifier: Apache-2.0
// A synthetic rig with known truth for the tests of compare/: images, decodes and fits made directly
// from formulas, without renderer or decoder.
#pragma once
#include <vector>

#include "compare/comparison.hpp"

namespace fringetwin::testing {

struct SidesTruth {
  int width = 192, height = 160, cameras = 1, steps = 4;
  std::vector<double> pitches_px = {13, 14, 15};
  int gray_bits = 0;
  double gain_dn = 17.3, black_level_dn = 4.2;            ///< of the real sensor
  double twin_gain_dn = 20.0, twin_black_level_dn = 0.0;  ///< what the twin believes
  int bit_depth = 8;
  double noise_dn = 1.5;
  double electrons_per_dn = 0.0;  ///< photon noise besides; 0 = none
  double contrast = 0.5;          ///< amplitude of the fringes over full light
  double albedo_sigma = 0.0;      ///< independent per pixel, common to all images
  double second_harmonic = 0.0;   ///< amplitude relative to the local mean gray level
  double geometry_rad = 0.0;      ///< independent per pixel, at the finest pitch
  double outlier_fraction = 0.0, outlier_dn = 0.0;
  double weight = 10.0;  ///< irradiance of a fully lit pixel in the middle
  bool round_real = true;
  bool published_only = false;
  unsigned seed = 1;
};

struct SyntheticSides {
  Twin twin;
  compare::Side real, simulated;
};

/// Irradiance at full light.
double weight_at(const SidesTruth& t, int x, int y);
/// A disc is lit; outside nothing is seen.
bool is_lit(const SidesTruth& t, int x, int y);
SyntheticSides make_sides(const SidesTruth& t);

}  // namespace fringetwin::testing
