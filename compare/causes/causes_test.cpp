// SPDX-License-Identifier: Apache-2.0
// Gray values of planted rigs: the cause is named, and gain and black level come with it where it explains
// them.
//
// | check                  | tolerance | origin                                         |
// |------------------------|-----------|------------------------------------------------|
// | gain, black level      | 4 sigma   | two numbers, normal: one seed in 8,000         |
// | blur                   | 1 %       | far beyond its sigma of 0.1 %                   |
#include "compare/causes/causes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::causes_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kWidth = 96, kHeight = 80;
constexpr double kGain = 20.0, kBlack = 7.0, kNoiseDn = 0.5, kBlurPx = 2.0;

Twin window_on_the_sphere() {
  const SphereShape ball = testing::physical_sphere();
  return testing::crop_around(testing::with_object(testing::paper_rig(), "ball", ball, {}), ball.center_mm,
                              kWidth, kHeight);
}

/// Returns the causes for a twin where the second camera saw `truth` through a sensor of kGain and kBlack,
/// image 3 brighter by `flicker`; the search begins at another gain and black level.
Causes causes_of(const Twin& truth, double flicker = 0.0) {
  render::Renderer renderer;
  GridSamples s;
  s.camera = 1;
  s.grid = {1, 0, kWidth, kHeight};
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, kNoiseDn);
  const std::vector<ImageF> images = render_grid(renderer, truth, s.camera, s.grid, 9);
  for (int k = 0; k < static_cast<int>(images.size()); ++k) s.images.push_back(k);
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    s.cell.push_back(i);
    for (std::size_t k = 0; k < images.size(); ++k) {
      const double bright = k == 3 ? 1.0 + flicker : 1.0;
      s.real_dn.push_back(static_cast<float>(kGain * bright * static_cast<double>(images[k].data[i]) +
                                             kBlack + noise(random)));
      s.weight.push_back(static_cast<float>(1.0 / kNoiseDn));
    }
  }
  s.gain_dn = 0.8 * kGain;
  s.black_level_dn = kBlack + 10.0;
  Sensitivity sensitivity(renderer, {std::move(s)});
  return find_causes(sensitivity, window_on_the_sphere());
}

Twin blurred() {
  Twin truth = window_on_the_sphere();
  truth.projector->blur_px = kBlurPx;
  return truth;
}

TEST(Causes, GainAndBlackLevelAreThoseThatGoWithTheBlur) {
  const Causes causes = causes_of(blurred());
  ASSERT_EQ(causes.named, "blur");
  EXPECT_NEAR(causes.rows[0].parameters.at(0).estimate, kBlurPx, 0.01 * kBlurPx);
  ASSERT_EQ(causes.gain.size(), 1u) << causes.why;
  const CauseGain& gain = causes.gain[0];
  EXPECT_EQ(gain.camera, "right");
  EXPECT_NEAR(gain.gain_dn, kGain, 4.0 * gain.gain_sigma_dn);
  EXPECT_NEAR(gain.black_level_dn, kBlack, 4.0 * gain.black_level_sigma_dn);
  EXPECT_GT(gain.gain_sigma_dn, 0.0);
  EXPECT_LT(gain.gain_sigma_dn, 0.01 * kGain);
  EXPECT_THAT(gain_sentence(causes), HasSubstr("with blur "));
  EXPECT_THAT(gain_sentence(causes), HasSubstr("px; right: gain "));
}

TEST(Causes, NoGainIsOfferedWhereTheCauseDoesNotExplainTheRest) {
  const Causes causes = causes_of(blurred(), 0.05);
  ASSERT_EQ(causes.named, "blur");
  EXPECT_THAT(causes.gain, IsEmpty());
  EXPECT_THAT(causes.why, HasSubstr("what is left is not explained"));
  EXPECT_THAT(gain_sentence(causes), HasSubstr("no gain or black level is offered with blur: "));
}

TEST(Causes, NoGainIsOfferedWithWhatIsOne) {
  Twin truth = window_on_the_sphere();
  truth.cameras[1].vignetting = {Vignetting::Kind::polynomial, {}, {0.2, 0.0}};
  const Causes causes = causes_of(truth);
  ASSERT_EQ(causes.named, "vignetting");
  EXPECT_THAT(causes.gain, IsEmpty());
  EXPECT_THAT(causes.why, HasSubstr("cannot be told from it"));
}

TEST(Causes, WhereNothingIsNamedNothingIsSaid) { EXPECT_EQ(gain_sentence({}), ""); }

}  // namespace
}  // namespace fringetwin::compare::causes_test
