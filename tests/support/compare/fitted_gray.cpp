// SPDX-License-Identifier: Apache-2.0
#include "tests/support/compare/fitted_gray.hpp"

#include <utility>

namespace fringetwin::testing {
namespace {

compare::GrayPair first_pair(const SyntheticSides& sides, std::vector<std::string>& warnings) {
  return compare::pair_gray(sides.twin, sides.real, sides.simulated, {}, warnings).at(0);
}

}  // namespace

SidesTruth deep_truth(double black_level_dn) {
  SidesTruth t;
  t.width = 256;
  t.height = 240;
  t.bit_depth = 12;
  t.gain_dn = 200.0;
  t.black_level_dn = black_level_dn;
  t.noise_dn = 4.0;
  return t;
}

SidesTruth coded_truth(double black_level_dn) {
  SidesTruth t = deep_truth(black_level_dn);
  t.pitches_px = {16};
  t.steps = 8;
  t.gray_bits = 5;
  return t;
}

SidesTruth misjudged_truth() {
  SidesTruth t;
  t.bit_depth = 12;
  t.gain_dn = 280.0;
  t.black_level_dn = 64.0;
  t.twin_gain_dn = 300.0;
  t.noise_dn = 9.0;
  return t;
}

compare::GrayPair gray_pair(const SyntheticSides& sides) {
  std::vector<std::string> ignored;
  return first_pair(sides, ignored);
}

FittedGray::FittedGray(SyntheticSides made, Margins margins)
    : sides(std::move(made)), pair(first_pair(sides, warnings)) {
  if (margins == Margins::residuals) {
    fit = compare::fit_gain(pair, warnings);
  } else {
    const compare::GrayNoise measured = noise();
    fit = compare::fit_gain(pair, warnings, &measured);
  }
}

}  // namespace fringetwin::testing
