// SPDX-License-Identifier: Apache-2.0
// A capture set that is not as described is found, and the reading that fits is named; one that is as
// described is left in peace. The images come from pattern_value() over known coordinates, not from the
// decoder.
#include "measure/description/doubts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "measure/decode/decode.hpp"
#include "tests/support/measure/synthetic_fringes.hpp"

namespace fringetwin::measure::doubts_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace support = fringetwin::testing;

constexpr double kWidth_px = 800.0;

Fringes three_pitches(int steps) {
  return support::one_direction(Unwrap::heterodyne, steps, {13.0, 14.0, 15.0}, {0.0, 0.0, 0.0});
}
Fringes coded(int steps, bool complementary) {
  GrayCode code;
  code.bits = complementary ? 6 : 7;
  code.complementary = complementary;
  return support::gray_fringes(steps, 16.0, 0.0, code);
}

support::FringeScene scene(double noise_dn = 1.5) {
  support::FringeScene s;
  s.noise_dn = noise_dn;
  s.column_px = support::ramp(320, 120, 150.0, 620.0, 30.0);
  s.footprint_px = 0.7;
  return s;
}

struct Told {
  std::vector<std::string> sentences;
  std::string all() const {
    std::string text;
    for (const std::string& s : sentences) text += s + "\n";
    return text;
  }
};

/// What is said of images when `described` is what the user wrote. `known`: the twin knows where everything
/// is.
Told told(const CameraImages& images, const Fringes& described, const support::FringeScene& s, bool known) {
  const DecodeOptions options = support::projector_of_width(kWidth_px);
  ExpectedCoordinates expected;
  if (known) expected.x_px = s.column_px;
  Told out;
  for (Doubt& doubt :
       description_doubts(images, described, options, decode(images, described, options), expected))
    out.sentences.push_back(std::move(doubt.sentence));
  return out;
}

CameraImages in_order(const CameraImages& images, const std::vector<int>& order) {
  CameraImages out = images;
  for (std::size_t i = 0; i < order.size(); ++i)
    out.images[i] = images.images[static_cast<std::size_t>(order[i])];
  return out;
}
std::vector<int> counted(std::size_t n) {
  std::vector<int> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<int>(i);
  return order;
}

TEST(Doubts, NoneAboutWhatIsAsDescribed) {
  for (const double noise_dn : {0.0, 1.5, 6.0})
    for (const Fringes& f :
         {three_pitches(3), three_pitches(4), three_pitches(8), coded(4, false), coded(4, true)}) {
      const support::FringeScene s = scene(noise_dn);
      EXPECT_THAT(told(support::project(f, s), f, s, true).sentences, IsEmpty())
          << noise_dn << " " << f.steps;
      EXPECT_THAT(told(support::project(f, s), f, s, false).sentences, IsEmpty());
    }
}

TEST(Doubts, NoneWhereOnlyThePoseIsWrongByFringes) {
  const Fringes f = three_pitches(4);
  support::FringeScene s = scene();
  const CameraImages images = support::project(f, s);
  for (const double moved_px : {3.1, 24.0, 90.0}) {
    support::FringeScene believed = s;
    for (std::size_t i = 0; i < believed.column_px.size(); ++i)
      believed.column_px.data[i] += moved_px * (1.0 + 0.2 * static_cast<double>(i % 320) / 320.0);
    EXPECT_THAT(told(images, f, believed, true).sentences, IsEmpty()) << moved_px;
  }
}

TEST(Doubts, NoneAboutAnEighthOfFlickerOrAResponseFarFromLinear) {
  const Fringes f = three_pitches(4);
  const support::FringeScene s = scene();
  CameraImages images = support::project(f, s);
  for (std::size_t k = 0; k < images.images.size(); ++k)
    for (float& v : images.images[k].as_floats()) v = std::round(v * (k % 2 == 0 ? 0.94f : 1.06f));
  EXPECT_THAT(told(images, f, s, true).sentences, IsEmpty());
  images = support::project(f, s);
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats()) v = std::round(210.0f * std::pow(v / 210.0f, 1.6f));
  EXPECT_THAT(told(images, f, s, true).sentences, IsEmpty());
}

// Each number of steps with an exchange that the twin's coordinates help to find and one without them; all of
// the three pitches have one.
TEST(Doubts, ExchangedImages) {
  struct Exchange {
    int steps;
    std::size_t image;  ///< and the next one
    bool known;
  };
  for (const auto& [steps, i, known] : {Exchange{3, 0, true}, Exchange{3, 4, false}, Exchange{4, 4, false},
                                        Exchange{4, 8, true}, Exchange{8, 0, true}, Exchange{8, 20, false}}) {
    const Fringes f = three_pitches(steps);
    const support::FringeScene s = scene();
    const CameraImages right = support::project(f, s);
    std::vector<int> order = counted(right.images.size());
    std::swap(order[i], order[i + 1]);
    const Told t = told(in_order(right, order), f, s, known);
    EXPECT_THAT(t.all(),
                HasSubstr("images " + std::to_string(i) + " and " + std::to_string(i + 1) + " swapped"))
        << steps << " steps, known " << known;
    EXPECT_EQ(t.sentences.size(), 1u);
  }
}

TEST(Doubts, RepeatedImages) {
  for (const int steps : {3, 4, 6}) {
    const Fringes f = three_pitches(steps);
    const support::FringeScene s = scene();
    const CameraImages right = support::project(f, s);
    for (std::size_t i = 1; i < right.images.size(); i += 3) {
      CameraImages wrong = right;
      support::FringeScene again = s;
      again.seed = 77;  // the same pattern recorded twice: noise of its own
      wrong.images[i] = support::project(f, again).images[i - 1];
      EXPECT_THAT(told(wrong, f, s, true).all(),
                  HasSubstr("image " + std::to_string(i) + " repeats image " + std::to_string(i - 1)))
          << steps;
    }
  }
}

TEST(Doubts, EveryImageIsTheOneBefore) {
  for (const int steps : {3, 4, 6}) {
    const Fringes f = three_pitches(steps);
    const support::FringeScene s = scene();
    const CameraImages right = support::project(f, s);
    std::vector<int> order = counted(right.images.size());
    std::rotate(order.begin(), order.end() - 1, order.end());
    EXPECT_THAT(told(in_order(right, order), f, s, false).all(), HasSubstr("starts one image late")) << steps;
    order = counted(right.images.size());
    std::rotate(order.begin(), order.begin() + 1, order.end());
    EXPECT_THAT(told(in_order(right, order), f, s, false).all(), HasSubstr("starts one image early"))
        << steps;
  }
}

TEST(Doubts, ADroppedImage) {
  const Fringes f = three_pitches(4);
  const support::FringeScene s = scene();
  const CameraImages right = support::project(f, s);
  std::vector<int> order = counted(right.images.size());
  for (std::size_t i = 6; i < order.size(); ++i)
    order[i] = static_cast<int>(std::min(i + 1, order.size() - 1));
  EXPECT_THAT(told(in_order(right, order), f, s, true).all(), HasSubstr("the pattern of image 6 was lost"));
}

TEST(Doubts, StepsInReverseOrder) {
  for (const Fringes& f : {three_pitches(4), three_pitches(5), coded(4, true), coded(6, true)}) {
    const support::FringeScene s = scene();
    const CameraImages right = support::project(f, s);
    std::vector<int> order = counted(right.images.size());
    const int n = f.steps;
    const int phase_images = n * static_cast<int>(f.directions[0].pitches_px.size());
    for (int i = 0; i < phase_images; ++i) order[static_cast<std::size_t>(i)] = i - i % n + (n - i % n) % n;
    EXPECT_THAT(told(in_order(right, order), f, s, true).all(), HasSubstr("steps in reverse order")) << n;
  }
}

TEST(Doubts, PitchesInAnotherOrder) {
  const support::FringeScene s = scene();
  const Fringes right = three_pitches(4);
  Fringes wrong = right;
  wrong.directions[0].pitches_px = {15.0, 14.0, 13.0};
  for (const bool known : {false, true})
    EXPECT_THAT(told(support::project(right, s), wrong, s, known).all(),
                HasSubstr("pitches in the order 13, 14, 15"));
  wrong.directions[0].pitches_px = {14.0, 15.0, 13.0};
  EXPECT_THAT(told(support::project(right, s), wrong, s, false).all(),
              HasSubstr("pitches in the order 13, 14, 15"));
}

TEST(Doubts, CodesDescribedWrongly) {
  const support::FringeScene s = scene();
  const Fringes right = coded(4, true);
  const CameraImages images = support::project(right, s);
  Fringes wrong = right;
  wrong.directions[0].gray->lsb_first = true;
  EXPECT_THAT(told(images, wrong, s, false).all(), HasSubstr("the bits of the code in the other order"));
  wrong = right;
  wrong.directions[0].gray->offset_periods = -0.5;
  EXPECT_THAT(told(images, wrong, s, false).all(), HasSubstr("the code 0.5 of a period further"));
  wrong = coded(4, false);
  EXPECT_THAT(told(images, wrong, s, false).all(), HasSubstr("a complementary bit as the last of the code"));
  EXPECT_THAT(told(support::project(wrong, s), right, s, false).all(), HasSubstr("no complementary bit"));
}

/// Makes a part of the images what no reading decodes, as edges and locks of a real part are: there each
/// image has gray values of its own.
void spoil(CameraImages& images, double share) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> gray(20.0f, 200.0f);
  for (GrayImage& image : images.images)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < static_cast<int>(share * image.width); ++x) image.writable(x, y) = gray(random);
}

// A code as SLStudio and others show it: its bits change where the fringes wrap, and the last one halves the
// period. Some pixels stay bad whatever is read.
TEST(Doubts, AHalfPeriodBitAmongPixelsThatNoReadingDecodes) {
  const support::FringeScene s = scene();
  Fringes right = coded(4, true);
  right.directions[0].gray->offset_periods = -0.5;
  CameraImages images = support::project(right, s);
  spoil(images, 0.02);
  Fringes as_bits = coded(4, false);
  EXPECT_THAT(told(images, as_bits, s, false).all(),
              HasSubstr("a complementary bit as the last of the code and offset_periods = -0.5 would leave"));
  Fringes no_offset = right;
  no_offset.directions[0].gray->offset_periods = 0.0;
  EXPECT_THAT(told(images, no_offset, s, false).all(), HasSubstr("the code 0.5 of a period further"));
  const CameraImages reversed = in_order(images, {0, 3, 2, 1, 4, 5, 6, 7, 8, 9, 10});
  EXPECT_THAT(told(reversed, right, s, false).all(), HasSubstr("steps in reverse order"));
}

// Where nothing settles it, what comes nearest is named as that.
TEST(Doubts, WhatNothingSettlesNamesTheNearest) {
  const support::FringeScene s = scene();
  const Fringes right = coded(4, true);
  CameraImages images = support::project(right, s);
  spoil(images, 0.35);
  Fringes wrong = right;
  wrong.directions[0].gray->lsb_first = true;
  const std::string all = told(images, wrong, s, false).all();
  EXPECT_THAT(all, AllOf(HasSubstr("no other reading of [fringes] that was tried takes most of this away"),
                         HasSubstr("(the best, the bits of the code in the other order would leave")));
}

TEST(Doubts, AComplementaryBitThatIsShownInverted) {
  const support::FringeScene s = scene();
  for (const auto threshold : {GrayCode::Threshold::mean, GrayCode::Threshold::inverse}) {
    Fringes f = coded(4, true);
    f.directions[0].gray->threshold = threshold;
    CameraImages images = support::project(f, s);
    const std::vector<PatternSpec> sequence = expand_sequence(f);
    for (std::size_t i = 0; i < sequence.size(); ++i)
      if (sequence[i].is_complementary())
        for (float& v : images.images[i].as_floats()) v = static_cast<float>(s.black_dn + s.white_dn) - v;
    EXPECT_THAT(told(images, f, s, false).all(), HasSubstr("the complementary bit inverted would leave"));
  }
}

TEST(Doubts, AnOriginThatIsHalfAPeriodOff) {
  const support::FringeScene s = scene();
  const Fringes right = coded(4, true);
  Fringes wrong = right;
  wrong.directions[0].phase_origin_px[0] -= 8.0;
  EXPECT_THAT(
      told(support::project(right, s), wrong, s, true).all(),
      AllOf(HasSubstr("may be not as described"), HasSubstr("phase_origin_px 0.5 of a period further"),
            HasSubstr("the projector or an object is displaced")));
}

TEST(Doubts, NothingToSeeIsNoDoubt) {
  const Fringes f = three_pitches(4);
  support::FringeScene s = scene();
  s.white_dn = 12.0;  // no modulation anywhere
  EXPECT_THAT(told(support::project(f, s), f, s, true).sentences, IsEmpty());
}

}  // namespace
}  // namespace fringetwin::measure::doubts_test
