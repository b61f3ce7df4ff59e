// SPDX-License-Identifier: Apache-2.0
// Pitches that are others than stated are told from phases that pattern_value() makes over known coordinates;
// right ones, noise, a response far from linear and edges are no contradiction.
//
// | check          | tolerance | origin |
// |----------------|-----------|------------------------------------------------------------------------------|
// | ratio of two   | 5e-4      | 30 lines of 470 px: phases of 0.03 rad at their ends, 36 turns: 2e-4 a line,
// | | pitches        |           | and harmonics of 0.05 rad at one end of all lines |
#include "measure/description/pitch_ratios.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "measure/decode/decode.hpp"
#include "tests/support/measure/synthetic_fringes.hpp"

namespace fringetwin::measure::pitch_ratios_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace support = fringetwin::testing;

Fringes three(double first, double second, double third) {
  return support::one_direction(Unwrap::heterodyne, 4, {first, second, third}, {0.0, 0.0, 0.0});
}

support::FringeScene scene() {
  support::FringeScene s;
  s.noise_dn = 1.5;
  s.column_px = support::ramp(320, 120, 150.0, 620.0, 30.0);
  s.footprint_px = 0.7;
  return s;
}

/// Images of what was shown, decoded as what is stated; `gamma` of the projector.
DirectionDecode decode_scene(const Fringes& shown, const Fringes& stated, const support::FringeScene& s,
                             double gamma) {
  CameraImages images = support::project(shown, s);
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats())
      if (gamma != 1.0) v = std::round(210.0f * std::pow(v / 210.0f, static_cast<float>(gamma)));
  return decode(images, stated, support::projector_of_width(800.0)).directions.at(0);
}

DirectionDecode decoded(const Fringes& shown, const Fringes& stated, double gamma = 1.0, double scale = 1.0,
                        bool edge = false) {
  support::FringeScene s = scene();
  for (std::size_t i = 0; i < s.column_px.size(); ++i) {
    s.column_px.data[i] *= scale;
    if (edge && i % 320 > 140) s.column_px.data[i] += 25.0;
  }
  return decode_scene(shown, stated, s, gamma);
}

/// A plane part, all of whose lines show the same fringes: what harmonics do at their ends adds up.
DirectionDecode decoded_plane(const Fringes& shown, const Fringes& stated, double gamma, double first_px,
                              double span_px) {
  support::FringeScene s = scene();
  s.noise_dn = 0.3;
  s.column_px = support::ramp(320, 120, first_px, first_px + span_px);
  return decode_scene(shown, stated, s, gamma);
}

TEST(PitchRatios, NoDoubtAboutRightOnes) {
  const Fringes f = three(13.0, 14.0, 15.0);
  for (const double gamma : {1.0, 1.6, 2.2})
    for (const bool edge : {false, true}) {
      const DirectionDecode d = decoded(f, f, gamma, 1.0, edge);
      const auto told = pitch_ratios(d);
      ASSERT_TRUE(told) << gamma;
      if (gamma == 1.0) {
        EXPECT_LT(told->worst, 5e-4);
      }
      EXPECT_FALSE(pitch_doubt(d)) << gamma << " " << *pitch_doubt(d);
    }
}

TEST(PitchRatios, AnotherOrderIsLeftToTheReadingThatSaysSo) {
  const DirectionDecode d = decoded(three(13.0, 14.0, 15.0), three(15.0, 14.0, 13.0));
  const auto told = pitch_ratios(d);
  ASSERT_TRUE(told);
  EXPECT_GT(told->worst, 0.1);
  EXPECT_FALSE(pitch_doubt(d));
  EXPECT_TRUE(pitch_doubt(decoded(three(13.0, 14.0, 15.1), three(15.0, 14.0, 13.0))));  // and one is off
}

TEST(PitchRatios, OneThatIsOff) {
  for (const std::size_t wrong : {0u, 1u, 2u}) {
    const std::vector<double> stated{13.0, 14.0, 15.0};
    std::vector<double> shown = stated;
    shown[wrong] *= 1.004;
    const DirectionDecode d = decoded(three(shown[0], shown[1], shown[2]), three(13.0, 14.0, 15.0));
    const auto told = pitch_ratios(d);
    ASSERT_TRUE(told);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(told->pitches_px[k] / shown[k], 1.0, 5e-4) << wrong << k;
    const auto sentence = pitch_doubt(d);
    ASSERT_TRUE(sentence) << wrong;
    EXPECT_THAT(*sentence, AllOf(HasSubstr("[fringes] pitches_px says 13 : 14 : 15"), HasSubstr("0.4")));
  }
}

// Harmonics of a gamma at the ends of 8 to 13 turns: of three steps they are far beyond noise and beyond a
// floor that does not know how long the runs are, and no contradiction all the same.
TEST(PitchRatios, HarmonicsOfShortRunsAreNoDoubt) {
  double worst_of_three = 0.0;
  for (const int steps : {3, 4})
    for (const double gamma : {1.6, 2.2})
      for (const double span_px : {120.0, 200.0})
        for (const double first_px : {100.0, 103.0, 107.0, 111.0, 177.0}) {
          Fringes f = three(13.0, 14.0, 15.0);
          f.steps = steps;
          const DirectionDecode d = decoded_plane(f, f, gamma, first_px, span_px);
          EXPECT_FALSE(pitch_doubt(d)) << steps << " " << gamma << " " << first_px << " " << *pitch_doubt(d);
          if (const auto told = pitch_ratios(d); told && steps == 3 && told->worst > 6.0 * told->sigma)
            worst_of_three = std::max(worst_of_three, told->worst);
        }
  EXPECT_GT(worst_of_three, 0.003) << "these scenes would tell nothing";
}

// The floor does not hide what is wrong: 2 % of 13 turns are a quarter of a turn.
TEST(PitchRatios, OneThatIsOffIsToldOfShortRuns) {
  for (const double gamma : {1.0, 2.2}) {
    const DirectionDecode d =
        decoded_plane(three(13.0, 14.28, 15.0), three(13.0, 14.0, 15.0), gamma, 100.0, 200.0);
    const auto told = pitch_ratios(d);
    ASSERT_TRUE(told);
    EXPECT_NEAR(told->turns_per_run, 200.0 / 15.0, 0.5);
    EXPECT_TRUE(pitch_doubt(d)) << gamma << " " << told->worst;
  }
}

// A camera turned by 90 degrees sees the fringes of columns one below the other.
TEST(PitchRatios, OneThatIsOffIsToldOfATurnedCamera) {
  support::FringeScene s = scene();
  s.column_px = ImageD(120, 320, 0.0);
  for (int y = 0; y < 320; ++y)
    for (int x = 0; x < 120; ++x) s.column_px(x, y) = 150.0 + 470.0 * y / 320.0 + 0.1 * x;
  const Fringes stated = three(13.0, 14.0, 15.0);
  EXPECT_FALSE(pitch_doubt(decode_scene(stated, stated, s, 1.0)));
  const auto told = pitch_ratios(decode_scene(three(13.0, 14.056, 15.0), stated, s, 1.0));
  ASSERT_TRUE(told);
  EXPECT_NEAR(told->pitches_px[1] / 14.056, 1.0, 5e-4);
  EXPECT_TRUE(pitch_doubt(decode_scene(three(13.0, 14.056, 15.0), stated, s, 1.0)));
}

TEST(PitchRatios, AScaleOfAllIsNotTold) {
  EXPECT_FALSE(pitch_doubt(decoded(three(13.13, 14.14, 15.15), three(13.0, 14.0, 15.0))));
}

TEST(PitchRatios, AFewFringesTellNothing) {
  const Fringes f = three(13.0, 14.0, 15.0);
  EXPECT_FALSE(pitch_ratios(decoded(f, f, 1.0, 0.1)));  // 47 px: three fringes
}

// Gray code alone and a direction of one pitch have no ratio.
TEST(PitchRatios, NothingToldWithoutTwoPitches) {
  DirectionDecode d = decoded(three(13.0, 14.0, 15.0), three(13.0, 14.0, 15.0));
  DirectionDecode one = d;
  one.pitches_px.resize(1), one.wrapped_rad.resize(1), one.finest = 0;
  EXPECT_FALSE(pitch_ratios(one));
  d.wrapped_rad.clear();
  EXPECT_FALSE(pitch_ratios(d));
  EXPECT_FALSE(pitch_doubt(d));
}

}  // namespace
}  // namespace fringetwin::measure::pitch_ratios_test
