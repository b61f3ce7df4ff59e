// SPDX-License-Identifier: Apache-2.0
// What is left follows what was planted: plain numbers, a camera of 60 x 50 pixels and 12 images, with a
// noise of one standard deviation.
//
// | check        | tolerance | origin |
// |--------------|-----------|-------------------------------------------------------------------------------|
// | shares       | 0.05      | chance: an excess of 36,000 to 70,000 is known to sqrt(2 * 36,000) = 270, the
// | |              |           | gain of up to 256 bins to 2.37 sqrt(256) = 38 |
#include "compare/pattern/pattern.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace fringetwin::compare::pattern_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kWidth = 60, kHeight = 50, kPitches = 3, kSteps = 4;
constexpr double kPi = std::numbers::pi;

using Planted = std::function<double(const LeftValue&)>;

/// A surface that is shaded from spot to spot, so that the gray level is no function of phase or place, or
/// one that is alike everywhere. `slant`: columns that the fringes move by from row to row.
LeftOver camera(const Planted& planted, double noise = 1.0, bool shaded = true, int first_x = 0,
                double slant = 0.0) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> shade(shaded ? 0.3 : 1.0, 1.0);
  LeftOver out{"left", 0.5 * (kWidth - 1), 0.5 * (kHeight - 1), {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = first_x; x < kWidth; ++x) {
      const double factor = shade(random);
      for (int image = 0; image < kPitches * kSteps; ++image) {
        const double phase = std::remainder(2.0 * kPi *
                                                ((x + slant * y) / (5.3 + 0.4 * (image / kSteps)) +
                                                 static_cast<double>(image % kSteps) / kSteps),
                                            2.0 * kPi);
        LeftValue v{.level_dn = static_cast<float>(20.0 + factor * (100.0 + 90.0 * std::cos(phase))),
                    .phase_rad = static_cast<float>(phase),
                    .x_px = static_cast<float>(x),
                    .y_px = static_cast<float>(y),
                    .image = image};
        v.sigmas = static_cast<float>(planted(v) + noise * normal(random));
        out.values.push_back(v);
      }
    }
  return out;
}

/// Returns chi2 about the mean, which is the black level's, less the number of values.
double excess_of(const LeftOver& left) {
  double sum = 0.0, squares = 0.0;
  for (const LeftValue& v : left.values) {
    sum += static_cast<double>(v.sigmas);
    squares += static_cast<double>(v.sigmas * v.sigmas);
  }
  const auto n = static_cast<double>(left.values.size());
  return squares - sum * sum / n - n;
}
std::vector<PatternRow> pattern_of(const LeftOver& left) { return find_pattern({left}, excess_of(left)); }

const PatternRow& row_of(const std::vector<PatternRow>& rows, const std::string& coordinate) {
  return *std::ranges::find(rows, coordinate, &PatternRow::coordinate);
}
/// Returns what is named, in order; two of the same order in that of the rows.
std::vector<std::string> named(const std::vector<PatternRow>& rows) {
  std::vector<std::string> names;
  for (int order = 1; order <= 7; ++order)
    for (const PatternRow& row : rows)
      if (row.order == order) names.push_back(row.coordinate);
  return names;
}

double of_level(const LeftValue& v) {
  return 1.5 * std::sin(2.0 * kPi * (static_cast<double>(v.level_dn) - 20.0) / 190.0);
}
double of_image(const LeftValue& v) { return v.image == 2 ? 3.0 : v.image == 7 ? -3.0 : 0.0; }
double of_radius(const LeftValue& v) {
  const double r = std::hypot(static_cast<double>(v.x_px) - 29.5, static_cast<double>(v.y_px) - 24.5) / 38.0;
  return 2.5 * (0.45 - r * r);
}
double of_phase(const LeftValue& v) { return 1.4 * std::sin(2.0 * static_cast<double>(v.phase_rad)); }
/// A slope along x and one along y.
double of_place(const LeftValue& v) {
  return (static_cast<double>(v.x_px) - 29.5) / 15.0 + (static_cast<double>(v.y_px) - 24.5) / 30.0;
}

TEST(Pattern, GrayLevel) {
  const auto rows = pattern_of(camera(of_level));
  EXPECT_THAT(named(rows), ElementsAre("gray_level"));
  EXPECT_NEAR(row_of(rows, "gray_level").alone, 1.0, 0.05);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("what is left follows the gray level ("));
  EXPECT_THAT(pattern_sentence(rows), HasSubstr(" % of it: response of the camera or the projector)"));
  EXPECT_THAT(pattern_sentence(rows), HasSubstr(", not the place"));
}

TEST(Pattern, ImageNumber) {
  const auto rows = pattern_of(camera(of_image));
  EXPECT_THAT(named(rows), ElementsAre("image"));
  const PatternRow& row = row_of(rows, "image");
  EXPECT_NEAR(row.alone, 1.0, 0.05);
  ASSERT_EQ(row.profile.size(), 1u);
  EXPECT_THAT(row.profile[0].at, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  EXPECT_NEAR(row.profile[0].mean[2], 3.0, 4.0 / std::sqrt(row.profile[0].n[2]));
  EXPECT_EQ(row.profile[0].n[2], kWidth * kHeight);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("light that changes from image to image"));
}

TEST(Pattern, RadiusIsNamedBeforeTheMapThatHoldsIt) {
  const auto rows = pattern_of(camera(of_radius));
  EXPECT_THAT(named(rows), ElementsAre("radius"));
  EXPECT_NEAR(row_of(rows, "radius").alone, 1.0, 0.05);
  EXPECT_GT(row_of(rows, "place").alone, 0.8);
}

TEST(Pattern, PhaseWithItsHarmonic) {
  const auto rows = pattern_of(camera(of_phase));
  EXPECT_THAT(named(rows), ElementsAre("phase"));
  EXPECT_EQ(row_of(rows, "phase").harmonic, 2u);
  EXPECT_NEAR(row_of(rows, "phase").alone, 1.0, 0.05);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("the phase of the fringes (2nd harmonic)"));
}

TEST(Pattern, StepsOfTheProjectorsLevelsFollowThePhase) {
  const auto rows = pattern_of(camera([](const LeftValue& v) {
    const double level = 12.0 + 12.0 * std::cos(static_cast<double>(v.phase_rad));
    return 5.0 * (std::round(level) - level);
  }));
  EXPECT_THAT(named(rows), ElementsAre("phase"));
  EXPECT_GT(row_of(rows, "phase").alone, 0.6);  // the steepest have 75 edges a period, in 256 bins
  EXPECT_EQ(row_of(rows, "phase").harmonic, 0u);
}

// Fringes along y in some images or in all: the steps are no error of single images.
TEST(Pattern, StepsOfTheProjectorsLevelsBothWaysFollowThePhase) {
  for (const int first_along_y : {0, 6}) {
    LeftOver left = camera([](const LeftValue&) { return 0.0; });
    for (LeftValue& v : left.values) {
      if (v.image >= first_along_y) {
        const double pitch_px = 5.3 + 0.4 * (v.image / kSteps);
        v.phase_rad = static_cast<float>(
            2.0 * kPi *
            (static_cast<double>(v.y_px) / pitch_px + static_cast<double>(v.image % kSteps) / kSteps));
      }
      const double level = 12.0 + 12.0 * std::cos(static_cast<double>(v.phase_rad));
      v.sigmas += static_cast<float>(5.0 * (std::round(level) - level));
    }
    EXPECT_THAT(named(pattern_of(left)), ElementsAre("phase")) << first_along_y;
  }
}

TEST(Pattern, PlaceThatIsNoRadius) {
  for (const int first_x : {0, 25}) {  // the part that is seen need not lie about the middle
    const auto rows = pattern_of(camera(of_place, 1.0, true, first_x));
    EXPECT_THAT(named(rows), ElementsAre("place")) << first_x;
    EXPECT_GT(row_of(rows, "place").alone, 0.9);
    // beside the middle a slope is in part one along the radius
    EXPECT_LT(row_of(rows, "radius").alone, first_x == 0 ? 0.1 : 0.5);
    // the middles of 16 x 16 cells over the pixels from first_x to 59 and from 0 to 49, row by row
    const PatternProfile& map = row_of(rows, "place").profile[0];
    ASSERT_EQ(map.at.size(), 256u);
    ASSERT_EQ(map.at_y.size(), 256u);
    const double cell_x = (kWidth - first_x) / 16.0, cell_y = kHeight / 16.0;
    for (std::size_t i = 0; i < 256; ++i) {
      EXPECT_NEAR(map.at[i], first_x - 0.5 + (static_cast<double>(i % 16) + 0.5) * cell_x, 1e-9);
      EXPECT_NEAR(map.at_y[i], -0.5 + (static_cast<double>(i / 16) + 0.5) * cell_y, 1e-9);
    }
  }
}

TEST(Pattern, SpotsAreNoRingsAndNoLevels) {
  std::mt19937 random(5);
  std::vector<double> spots;
  for (int i = 0; i < 20 * 20; ++i)
    spots.push_back(std::uniform_real_distribution<double>(-3.0, 3.0)(random));
  const auto rows = pattern_of(camera([&](const LeftValue& v) {
    return spots[static_cast<std::size_t>(v.y_px) / 3 * 20 + static_cast<std::size_t>(v.x_px) / 3];
  }));
  for (const char* one : {"gray_level", "phase", "image", "radius"}) {
    EXPECT_EQ(row_of(rows, one).order, 0) << one;
    EXPECT_LT(row_of(rows, one).alone, 0.05) << one;  // means over the same spots would take more
  }
}

TEST(Pattern, NoiseFollowsNothing) {
  LeftOver left = camera([](const LeftValue&) { return 0.0; });
  for (const PatternRow& row : find_pattern({left}, 2000.0)) {
    EXPECT_EQ(row.order, 0);
    EXPECT_LT(row.alone, 0.1) << row.coordinate;
  }
  // nor does it where it is thrice what is stated: that is no pattern
  left = camera([](const LeftValue&) { return 0.0; }, 3.0);
  const auto rows = pattern_of(left);
  EXPECT_THAT(named(rows), IsEmpty());
  EXPECT_EQ(
      pattern_sentence(rows),
      "what is left follows none of gray level, phase of the fringes (nor by place or image), image number, "
      "radius and place: no pattern found");
}

TEST(Pattern, TwoAtOnceAreBothNamedTheLargerOneFirst) {
  const LeftOver left = camera([](const LeftValue& v) { return of_level(v) + 0.5 * of_image(v); });
  const auto rows = pattern_of(left);
  EXPECT_THAT(named(rows), ElementsAre("gray_level", "image"));
  EXPECT_NEAR(row_of(rows, "gray_level").in_order + row_of(rows, "image").in_order, 1.0, 0.05);
  // two images of twelve are 1.5 off
  const double per_value = excess_of(left) / static_cast<double>(left.values.size());
  EXPECT_NEAR(row_of(rows, "image").in_order, 1.5 * 1.5 * 2.0 / 12.0 / per_value, 0.05);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("), then the image number ("));
}

TEST(Pattern, LevelAndPhaseOfAnEvenSurfaceCannotBeToldApart) {
  const auto rows = pattern_of(camera(of_level, 1.0, false));
  EXPECT_THAT(named(rows), ElementsAre("gray_level", "phase"));
  EXPECT_EQ(row_of(rows, "gray_level").order, row_of(rows, "phase").order);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("cannot be told apart here"));
}

// A harmonic of one sign at the left and the other at the right is nothing on average over the image.
TEST(Pattern, PhaseThatDiffersFromPlaceToPlace) {
  const auto of_both = [](const LeftValue& v) {
    return (static_cast<double>(v.x_px) - 29.5) / 20.0 * std::cos(5.0 * static_cast<double>(v.phase_rad));
  };
  const LeftOver left = camera(of_both);
  const auto rows = pattern_of(left);
  EXPECT_THAT(named(rows), ElementsAre("phase_by_place"));
  EXPECT_LT(row_of(rows, "phase").alone, 0.05);
  EXPECT_LT(row_of(rows, "place").alone, 0.05);
  const PatternRow& row = row_of(rows, "phase_by_place");
  // columns of 15 px hold 15/16 of a slope's squares, 32 bins 92 % of them, other images lie elsewhere in
  // both
  EXPECT_GT(row.alone, 0.7);
  EXPECT_EQ(row.harmonic, 5u);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("from place to place another way (5th harmonic)"));
  EXPECT_THAT(pattern_sentence(rows), Not(HasSubstr("not the place")));
  const PatternProfile& p = row.profile[0];
  ASSERT_EQ(p.mean.size(), 16u * 32u);
  EXPECT_EQ(p.at_y[31], 1.0);
  EXPECT_EQ(p.at_y[32], 2.0);
  EXPECT_LT(p.mean[0], -0.5);      // the first cell is at the left, and the fringes are brightest there
  EXPECT_GT(p.mean[3 * 32], 0.5);  // the last of its row
}

// A fifth harmonic in two images of twelve, of one sign and of the other, as where their exposures miss parts
// of the projector's frame: over all images it is nothing.
TEST(Pattern, PhaseThatDiffersFromImageToImage) {
  const auto in_two_images = [](const LeftValue& v) {
    const double sign = v.image == 5 ? 1.0 : v.image == 10 ? -1.0 : 0.0;
    return 1.5 * sign * std::cos(5.0 * static_cast<double>(v.phase_rad) + 1.0);
  };
  const LeftOver left = camera(in_two_images, 1.0, true, 0, 0.31);
  const auto rows = pattern_of(left);
  EXPECT_THAT(named(rows), ElementsAre("phase_by_image"));
  const PatternRow& row = row_of(rows, "phase_by_image");
  // 32 bins hold sinc(5/32)^2 of a fifth harmonic's squares, and the means of pixels take a twelfth of each
  EXPECT_NEAR(row.in_order, 0.92 * 11.0 * 11.0 / 144.0, 0.07);
  EXPECT_LT(row_of(rows, "phase").alone, 0.05);
  EXPECT_LT(row_of(rows, "image").alone, 0.05);
  EXPECT_EQ(row.harmonic, 5u);
  EXPECT_THAT(pattern_sentence(rows), HasSubstr("from image to image another way (5th harmonic)"));
  const PatternProfile& p = row.profile[0];
  ASSERT_EQ(p.mean.size(), 12u * 32u);
  EXPECT_EQ(p.at_y[5 * 32], 5.0);
  EXPECT_NEAR(p.mean[5 * 32], 1.5 * std::cos(1.0 + 5.0 * kPi / 32.0), 0.4);
}

// Columns that differ, alike in all images, lie along the fringes: they are no error of single images, and
// hide none.
TEST(Pattern, ColumnsAreNoPhaseByImageAndHideNone) {
  const auto columns = [](const LeftValue& v) {
    return 0.9 * std::sin(7.0 * static_cast<double>(v.x_px) * static_cast<double>(v.x_px));
  };
  constexpr double kSlant = 0.02;  // a column is a fringe still, and the rows differ a little
  EXPECT_THAT(named(pattern_of(camera(columns, 1.0, true, 0, kSlant))), Not(Contains("phase_by_image")));
  const auto with_two_images = [&](const LeftValue& v) {
    const double sign = v.image == 5 ? 1.0 : v.image == 10 ? -1.0 : 0.0;
    return columns(v) + 2.0 * sign * std::cos(3.0 * static_cast<double>(v.phase_rad) + 1.0);
  };
  EXPECT_THAT(named(pattern_of(camera(with_two_images, 1.0, true, 0, kSlant))), Contains("phase_by_image"));
}

// A level of each image and a harmonic alike in all of them, each too small to be named beside spots: both
// together are no waveform of single images.
TEST(Pattern, SmallPartsAreNoPhaseByAnother) {
  const auto small = [](const LeftValue& v) {
    const double spot =
        std::sin(12.9898 * static_cast<double>(v.x_px) + 78.233 * static_cast<double>(v.y_px));
    return 1.9 * spot + 0.33 * of_image(v) + 0.56 * std::cos(2.0 * static_cast<double>(v.phase_rad));
  };
  const auto rows = pattern_of(camera(small, 1.0, true, 0, 0.31));
  EXPECT_GT(row_of(rows, "phase_by_image").alone, 0.1);
  EXPECT_THAT(named(rows), Not(Contains("phase_by_image")));
  EXPECT_THAT(named(rows), Not(Contains("phase_by_place")));
}

// A waveform that differs over the image and one of two images: both are named, the larger one first.
TEST(Pattern, PhaseByPlaceAndByImageAtOnce) {
  const auto both = [](const LeftValue& v) {
    const auto phase = static_cast<double>(v.phase_rad);
    return (static_cast<double>(v.x_px) - 29.5) / 20.0 * std::cos(5.0 * phase) +
           (v.image == 5 || v.image == 10 ? 1.5 * std::cos(4.0 * phase) : 0.0);
  };
  EXPECT_THAT(named(pattern_of(camera(both, 1.0, true, 0, 0.31))),
              ElementsAre("phase_by_place", "phase_by_image"));
}

// Phase and place that are two errors are named as those.
TEST(Pattern, PhaseAndPlaceApartAreNoPhaseByPlace) {
  EXPECT_THAT(named(pattern_of(camera([](const LeftValue& v) { return of_phase(v) + of_place(v); }))),
              ElementsAre("place", "phase"));
  EXPECT_THAT(named(pattern_of(camera(of_phase))), ElementsAre("phase"));
}

TEST(Pattern, WhatHasNoPhaseAndACameraThatSeesNothingAreNoHindrance) {
  LeftOver left = camera(of_image), empty{"right", 0.0, 0.0, {}};
  for (LeftValue& v : left.values) v.phase_rad = NAN;
  const auto rows = find_pattern({left, empty}, excess_of(left));
  EXPECT_THAT(named(rows), ElementsAre("image"));
  EXPECT_EQ(row_of(rows, "phase").alone, 0.0);
  EXPECT_EQ(row_of(rows, "image").profile.size(), 1u);
  EXPECT_THAT(find_pattern({empty}, 100.0), IsEmpty());
}

}  // namespace
}  // namespace fringetwin::compare::pattern_test
