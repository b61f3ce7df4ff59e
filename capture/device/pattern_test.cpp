// SPDX-License-Identifier: Apache-2.0
#include "capture/device/pattern.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace fringetwin::testing::pattern_test {
namespace {

using namespace fringetwin::capture;

Fringes fringes_with_two_directions() {
  Fringes fringes;
  fringes.steps = 4;
  for (const Axis axis : {Axis::x, Axis::y}) {
    DirectionFringes direction;
    direction.axis = axis;
    direction.pitches_px = {13.0, 15.0};
    direction.phase_origin_px = {0.0, 2.5};
    fringes.directions.push_back(direction);
  }
  return fringes;
}

// The formula of docs/CONVENTIONS.md, "Fringes", written out once more.
double expected(double at_px, double origin_px, double pitch_px, int step) {
  return 0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * ((at_px - origin_px) / pitch_px + step / 4.0));
}

TEST(CapturePattern, SequenceIsTheTwinsInOrder) {
  const Fringes fringes = fringes_with_two_directions();
  const std::vector<Pattern> patterns = sequence_patterns(fringes);
  ASSERT_EQ(patterns.size(), 16u);
  for (std::size_t i = 0; i < patterns.size(); ++i) EXPECT_EQ(patterns[i].index, static_cast<int>(i));
  EXPECT_EQ(patterns[5].label, "x pitch 15 step 2/4");
  EXPECT_EQ(patterns[8].label, "y pitch 13 step 1/4");
}

TEST(CapturePattern, LevelsAreTheFormulaAtPixelCentres) {
  const Fringes fringes = fringes_with_two_directions();
  const std::vector<Pattern> patterns = sequence_patterns(fringes);
  const ImageF along_x = pattern_levels(fringes, patterns[5], 40, 30);
  const ImageF along_y = pattern_levels(fringes, patterns[8 + 7], 40, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      EXPECT_NEAR(along_x(x, y), expected(x, 2.5, 15.0, 1), 1e-7);  // float's rounding below 1
      EXPECT_NEAR(along_y(x, y), expected(y, 2.5, 15.0, 3), 1e-7);
    }
}

TEST(CapturePattern, EvenFieldsAndImages) {
  Fringes fringes = fringes_with_two_directions();
  auto picture = std::make_shared<ImageF>(4, 3, 0.25f);
  (*picture)(2, 1) = 0.75f;
  fringes.images.push_back({"", picture});
  EXPECT_EQ(pattern_levels(fringes, even_field(1.0, "white"), 4, 3).data, std::vector<float>(12, 1.0f));
  EXPECT_EQ(pattern_levels(fringes, sequence_patterns(fringes).back(), 4, 3).data, picture->data);
}

TEST(CapturePattern, QuantisationRoundsToTheNearestLevel) {
  ImageF levels(5, 1);
  levels.data = {0.0f, 1.0f, 0.5f, 0.1f, 1.5f};
  EXPECT_THAT(quantise_levels(levels, 8).data, ::testing::ElementsAre(0, 255, 128, 26, 255));
  EXPECT_THAT(quantise_levels(levels, 10).data, ::testing::ElementsAre(0, 1023, 512, 102, 1023));
  EXPECT_THAT(quantise_levels(levels, 16).data, ::testing::ElementsAre(0, 65535, 32768, 6554, 65535));
}

}  // namespace
}  // namespace fringetwin::testing::pattern_test
