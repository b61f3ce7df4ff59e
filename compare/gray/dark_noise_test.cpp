// SPDX-License-Identifier: Apache-2.0
// Noise of dark values from made images of a code, and what the noise of all levels makes of it.
//
// | check                       | tolerance | origin                                                     |
// |-----------------------------|-----------|------------------------------------------------------------|
// | variance of the dark values | 8 %       | 4 standard errors: sqrt(2/n), 2,600 differences and more   |
// | its level                   | 0.2 DN    | noise of 4 DN over as many, and what light is left in them |
#include "compare/gray/dark_noise.hpp"

#include <gtest/gtest.h>

#include "compare/gray/gray_noise.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::dark_noise_test {
namespace {

using testing::FittedGray;
using testing::SidesTruth;

/// Photon noise as of a rig with few electrons: the dark values have a hundredth of the bright ones'
/// variance.
SidesTruth coded(double black_level_dn = 60.0) {
  SidesTruth t = testing::coded_truth(black_level_dn);
  t.steps = 4;
  t.electrons_per_dn = 2.0;
  t.noise_dn = 2.0;
  t.contrast = 0.4;
  return t;
}

TEST(DarkNoise, IsThatOfTheReadOut) {
  const FittedGray gray(testing::make_sides(coded()));
  const auto dark = dark_noise(gray.pair);
  ASSERT_TRUE(dark);
  EXPECT_NEAR(dark->variance_dn2 / (4.0 + 1.0 / 12.0), 1.0, 0.08);
  EXPECT_NEAR(dark->level_dn, 60.0, 0.2);
  const GrayNoise noise = gray.noise();
  EXPECT_NEAR(noise.variance(dark->level_dn - 1.0), dark->variance_dn2, 1e-9);
  // half the light, a level between: photons make the rest
  EXPECT_NEAR(noise.variance(560.0) / (4.0 + 1.0 / 12.0 + 500.0 / 2.0), 1.0, 0.05);
}

TEST(DarkNoise, HasNoTextureOfTheRoomsLight) {
  testing::SyntheticSides sides = testing::make_sides(coded());
  std::vector<GrayImage>& real = sides.real.images[0].images;
  for (GrayImage& image : real)
    for (std::size_t i = 0; i < image.size(); ++i) image.as_floats()[i] += static_cast<float>(i * 7 % 40);
  const FittedGray gray(std::move(sides));
  const auto dark = dark_noise(gray.pair);
  ASSERT_TRUE(dark);
  EXPECT_NEAR(dark->variance_dn2 / (4.0 + 1.0 / 12.0), 1.0, 0.08);
}

TEST(DarkNoise, IsNotToldWhereItIsCutOffOrThereIsNoCode) {
  const FittedGray cut_off(testing::make_sides(coded(0.0)));
  EXPECT_FALSE(dark_noise(cut_off.pair));
  SidesTruth t = coded();
  t.gray_bits = 0;
  const FittedGray uncoded(testing::make_sides(t));
  EXPECT_FALSE(dark_noise(uncoded.pair));
}

}  // namespace
}  // namespace fringetwin::compare::dark_noise_test
