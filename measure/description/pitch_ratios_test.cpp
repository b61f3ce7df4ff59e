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

/// Decodes images of what was shown as what is stated; `gamma` of the projector.
DirectionDecode decoded(const Fringes& shown, const Fringes& stated, double gamma = 1.0, double scale = 1.0,
                        bool edge = false) {
  support::FringeScene s = scene();
  for (std::size_t i = 0; i < s.column_px.size(); ++i) {
    s.column_px.data[i] *= scale;
    if (edge && i % 320 > 140) s.column_px.data[i] += 25.0;
  }
  CameraImages images = support::project(shown, s);
  for (ImageF& image : images.images)
    for (float& v : image.data)
      if (gamma != 1.0) v = std::round(210.0f * std::pow(v / 210.0f, static_cast<float>(gamma)));
  return decode(images, stated, support::projector_of_width(800.0)).directions.at(0);
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

TEST(PitchRatios, AScaleOfAllIsNotTold) {
  EXPECT_FALSE(pitch_doubt(decoded(three(13.13, 14.14, 15.15), three(13.0, 14.0, 15.0))));
}

TEST(PitchRatios, AFewFringesTellNothing) {
  const Fringes f = three(13.0, 14.0, 15.0);
  EXPECT_FALSE(pitch_ratios(decoded(f, f, 1.0, 0.1)));  // 47 px: three fringes
}

}  // namespace
}  // namespace fringetwin::measure::pitch_ratios_test
