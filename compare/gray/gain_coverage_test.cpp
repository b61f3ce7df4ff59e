// SPDX-License-Identifier: Apache-2.0
// Do the gain's standard errors hold? Seeds 1000...1099, chosen before the first run.
// | check                              | tolerance        | origin                                        |
// |------------------------------------|------------------|-----------------------------------------------|
// | coverage of 68 / 95 %, 100 draws   | 54-82 / 88-100   | 3 standard errors of a binomial               |
#include <gtest/gtest.h>

#include <iostream>

#include "compare/gray/gain_fit.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gain_coverage_test {
namespace {

using testing::SidesTruth;

/// Share of draws whose truth lies within 1 and 1.96 reported sigmas.
std::pair<int, int> coverage(SidesTruth t, int draws) {
  int within_68 = 0, within_95 = 0;
  for (int i = 0; i < draws; ++i) {
    t.seed = 1000u + static_cast<unsigned>(i);
    const GainRow row = testing::FittedGray(testing::make_sides(t)).fit.row;
    const double z = std::abs(row.gain_dn - t.gain_dn) / row.gain_sigma_dn;
    within_68 += z < 1.0;
    within_95 += z < 1.96;
  }
  std::cout << "of " << draws << " draws within 1 sigma: " << within_68
            << ", within 1.96 sigma: " << within_95 << "\n";
  return {within_68, within_95};
}

TEST(GainCoverage, IntervalsCoverTheTruth) {
  SidesTruth t;
  t.width = t.height = 224;
  t.pitches_px = {13};
  const auto [within_68, within_95] = coverage(t, 100);
  EXPECT_GE(within_68, 54);
  EXPECT_LE(within_68, 82);
  EXPECT_GE(within_95, 88);
}

TEST(GainCoverage, IntervalsCoverTheTruthWithAlbedoCommonToAllImages) {
  // An independent-noise sigma would be too small by the square root of the number of images.
  SidesTruth t;
  t.width = t.height = 224;
  t.pitches_px = {13};
  t.noise_dn = 0.3;
  t.albedo_sigma = 0.04;
  const auto [within_68, within_95] = coverage(t, 100);
  EXPECT_GE(within_68, 54);
  EXPECT_GE(within_95, 88);
}

}  // namespace
}  // namespace fringetwin::compare::gain_coverage_test
