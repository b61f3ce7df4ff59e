// SPDX-License-Identifier: Apache-2.0
// tolerance  unit        origin
// 1e-14      full scale  one cosine of an argument up to 200 rad: 200 * 1.1e-16
// 1e-12      rad         phase from N steps: the above over the modulation, summed
// exact      -           Gray bits, order, labels
#include "twin/fringes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"
#include "twin/sequence_outline.hpp"

namespace fringetwin::fringes_test {
namespace {

using ::testing::ElementsAre;
using Kind = PatternSpec::Kind;

constexpr double pi = std::numbers::pi;

Fringes gray_fringes(double pitch_px, const GrayCode& gray, int steps = 0, double origin_px = 0.0) {
  Fringes fringes;
  fringes.steps = steps;
  fringes.unwrap = Unwrap::gray;
  fringes.directions = {{Axis::x, {pitch_px}, {origin_px}, gray}};
  return fringes;
}

std::vector<std::string> labels(const Fringes& fringes) {
  std::vector<std::string> all;
  for (const PatternSpec& p : expand_sequence(fringes)) all.push_back(p.label(fringes));
  return all;
}

/// Word index from the projected bits at x, by the definition of the binary-reflected code:
/// binary bit = running exclusive-or from the most significant bit.
int decode_word(const Fringes& fringes, double x_px) {
  int word = 0, binary_bit = 0;
  for (int bit = 0; bit < fringes.directions[0].gray->bits; ++bit) {
    PatternSpec p;
    p.kind = Kind::gray_bit;
    p.bit = bit;
    binary_bit ^= static_cast<int>(pattern_value(fringes, p, x_px));
    word = 2 * word + binary_bit;
  }
  return word;
}

double complementary(const Fringes& fringes, double x_px) {
  PatternSpec p;
  p.kind = Kind::complementary;
  return pattern_value(fringes, p, x_px);
}

TEST(Fringes, OrderIsDirectionPitchStep) {
  Fringes fringes;
  fringes.steps = 3;
  fringes.directions = {{Axis::x, {13, 14.5}, {0, 0}, {}}, {Axis::y, {20}, {0}, {}}};
  EXPECT_THAT(labels(fringes),
              ElementsAre("x pitch 13 step 1/3", "x pitch 13 step 2/3", "x pitch 13 step 3/3",
                          "x pitch 14.5 step 1/3", "x pitch 14.5 step 2/3", "x pitch 14.5 step 3/3",
                          "y pitch 20 step 1/3", "y pitch 20 step 2/3", "y pitch 20 step 3/3"));
}

TEST(Fringes, GrayFollowsTheStepsOfItsDirection) {
  Fringes fringes;
  fringes.steps = 1;
  GrayCode gray;
  gray.bits = 2;
  gray.complementary = true;
  fringes.directions = {{Axis::x, {16}, {0}, gray}, {Axis::y, {16}, {0}, {}}};
  EXPECT_THAT(labels(fringes), ElementsAre("x pitch 16 step 1/1", "x gray bit 1/2 (most significant)",
                                           "x gray bit 2/2 (least significant)", "x complementary bit",
                                           "y pitch 16 step 1/1"));
}

TEST(Fringes, LsbFirstReversesTheBitsOnly) {
  GrayCode gray;
  gray.bits = 3;
  gray.lsb_first = true;
  gray.complementary = true;
  EXPECT_THAT(labels(gray_fringes(8, gray)),
              ElementsAre("x gray bit 3/3 (least significant)", "x gray bit 2/3",
                          "x gray bit 1/3 (most significant)", "x complementary bit"));
}

TEST(Fringes, InverseThresholdGivesPairs) {
  GrayCode gray;
  gray.bits = 2;
  gray.complementary = true;
  gray.threshold = GrayCode::Threshold::inverse;
  const Fringes fringes = gray_fringes(8, gray);
  EXPECT_THAT(labels(fringes),
              ElementsAre("x gray bit 1/2 (most significant)", "x gray bit 1/2 (most significant) inverse",
                          "x gray bit 2/2 (least significant)", "x gray bit 2/2 (least significant) inverse",
                          "x complementary bit", "x complementary bit inverse"));
  const auto sequence = expand_sequence(fringes);
  for (std::size_t i = 0; i < sequence.size(); i += 2)
    for (double x = -20; x < 40; x += 0.5)
      EXPECT_EQ(pattern_value(fringes, sequence[i], x) + pattern_value(fringes, sequence[i + 1], x), 1.0);
  EXPECT_FALSE(needs_white_black(fringes));
}

// A miscounted set is answered with what the numbers mean, not with a line per image.
TEST(Fringes, OutlineNamesBlocksByNumber) {
  GrayCode gray;
  gray.bits = 6;
  gray.complementary = true;
  gray.threshold = GrayCode::Threshold::inverse;
  Fringes fringes = gray_fringes(16, gray, 4);
  EXPECT_EQ(sequence_outline(fringes),
            "0-3: x pitch 16 in 4 steps; 4-17: x 6 gray bits, most significant first, and the complementary "
            "bit, each with its inverse");
  gray = {.bits = 3, .lsb_first = true};
  fringes.directions = {{Axis::x, {13, 14, 15}, {0, 0, 0}, {}}, {Axis::y, {16}, {0}, gray}};
  EXPECT_EQ(sequence_outline(fringes),
            "0-3: x pitch 13 in 4 steps; 4-7: x pitch 14 in 4 steps; 8-11: x pitch 15 in 4 steps; 12-15: y "
            "pitch 16 in 4 steps; 16-18: y 3 gray bits, least significant first");
  fringes.directions.pop_back();
  fringes.images = {{}};
  EXPECT_THAT(sequence_outline(fringes), ::testing::EndsWith("; 12: images"));
}

TEST(Fringes, WhiteBlackThresholdNeedsReferences) {
  GrayCode gray;
  gray.bits = 2;
  gray.threshold = GrayCode::Threshold::white_black;
  EXPECT_TRUE(needs_white_black(gray_fringes(8, gray)));
}

TEST(Fringes, ZeroStepsMeansNoPhaseImages) {
  GrayCode gray;
  gray.bits = 5;
  EXPECT_EQ(expand_sequence(gray_fringes(8, gray)).size(), 5u);
}

TEST(Fringes, CosineAtKnownPlaces) {
  Fringes fringes;
  fringes.directions = {{Axis::x, {16}, {3}, {}}};
  fringes.mean = 0.5;
  fringes.amplitude = 0.4;
  PatternSpec p;
  EXPECT_NEAR(pattern_value(fringes, p, 3), 0.9, 1e-14);     // the phase origin is a maximum at n = 0
  EXPECT_NEAR(pattern_value(fringes, p, 11), 0.1, 1e-14);    // half a period
  EXPECT_NEAR(pattern_value(fringes, p, 1603), 0.9, 1e-12);  // 100 periods on
  p.step = 1;                                                // +2 pi / 4: cos(pi/2) at the origin, falling
  EXPECT_NEAR(pattern_value(fringes, p, 3), 0.5, 1e-14);
  EXPECT_LT(pattern_value(fringes, p, 4), 0.5);
}

TEST(Fringes, EveryPitchHasItsOwnOrigin) {
  Fringes fringes;
  fringes.directions = {{Axis::x, {13, 14, 15}, {3, -20, 4.5}, {}}};
  fringes.amplitude = 0.25;
  for (int pitch = 0; pitch < 3; ++pitch) {
    const double origin_px = fringes.directions[0].phase_origin_px[static_cast<std::size_t>(pitch)];
    const double half_px = 0.5 * fringes.directions[0].pitches_px[static_cast<std::size_t>(pitch)];
    PatternSpec p;
    p.pitch = pitch;
    EXPECT_NEAR(pattern_value(fringes, p, origin_px), 0.75, 1e-14);
    EXPECT_NEAR(pattern_value(fringes, p, origin_px + half_px), 0.25, 1e-14);
  }
}

// What is shown stays the sinusoid; the light besides it goes with the phase of the step.
TEST(Fringes, HarmonicsAreLightThatIsNotShown) {
  Fringes fringes;
  fringes.directions = {{Axis::x, {16, 20}, {3, 0}, {}, {{{0.02, -0.01}, {0.0, 0.005}}, {}}}};
  PatternSpec p;
  for (int step = 0; step < 4; ++step) {
    p.step = step;
    for (double x = -20.0; x < 40.0; x += 0.7) {
      const double t = 2.0 * std::numbers::pi * ((x - 3.0) / 16.0 + step / 4.0);
      EXPECT_NEAR(pattern_value(fringes, p, x), 0.5 + 0.5 * std::cos(t), 1e-14);
      EXPECT_NEAR(harmonic_light(fringes, p, x),
                  0.02 * std::cos(2 * t) - 0.01 * std::sin(2 * t) + 0.005 * std::sin(3 * t), 1e-15);
    }
  }
  p.pitch = 1;
  EXPECT_EQ(harmonic_light(fringes, p, 1.0), 0.0);
  p.kind = PatternSpec::Kind::gray_bit;
  EXPECT_EQ(harmonic_light(fringes, p, 1.0), 0.0);
}

TEST(Fringes, WaveformsAtKnownPlaces) {
  Fringes fringes;
  fringes.directions = {{Axis::x, {16}, {3}, {}}};
  fringes.mean = 0.5;
  fringes.amplitude = 0.4;
  fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  PatternSpec p;
  for (const auto& [x, value] :
       {std::pair{3.0, 0.9}, {6.9, 0.9}, {7.1, 0.1}, {14.9, 0.1}, {15.1, 0.9}, {-1.1, 0.1}})
    EXPECT_NEAR(pattern_value(fringes, p, x), value, 1e-15) << x;
  p.step = 1;  // a quarter of the period on
  EXPECT_NEAR(pattern_value(fringes, p, 3.1), 0.1, 1e-15);
  fringes.waveform = {Waveform::Kind::table, {1.0, 0.5, 0.0, 0.25}};
  p.step = 0;
  for (const auto& [x, v] :
       {std::pair{3.0, 1.0}, {5.0, 0.75}, {7.0, 0.5}, {11.0, 0.0}, {13.0, 0.125}, {17.0, 0.625}})
    EXPECT_NEAR(pattern_value(fringes, p, x), 0.1 + 0.8 * v, 1e-14) << x;
}

TEST(Fringes, PhaseOfStepZeroIsRecoveredFromTheSteps) {
  for (const int steps : {3, 4, 5, 12}) {
    Fringes fringes;
    fringes.steps = steps;
    fringes.directions = {{Axis::x, {13.5}, {-0.5}, {}}};
    for (double x = -0.5; x < 400; x += 0.37) {
      double c = 0, s = 0;
      for (const PatternSpec& p : expand_sequence(fringes)) {
        const double value = pattern_value(fringes, p, x);
        c += value * std::cos(2 * pi * p.step / steps);
        s -= value * std::sin(2 * pi * p.step / steps);
      }
      const double expected = 2 * pi * (x + 0.5) / 13.5;
      EXPECT_NEAR(std::remainder(std::atan2(s, c) - expected, 2 * pi), 0.0, 1e-12)
          << steps << " steps at " << x;
    }
  }
}

TEST(Fringes, FourWordsOfTwoBits) {
  GrayCode gray;
  gray.bits = 2;
  const Fringes fringes = gray_fringes(10, gray);
  // words 0..3 = 00 01 11 10
  const auto value = [&](int bit, double x) {
    PatternSpec p;
    p.kind = Kind::gray_bit;
    p.bit = bit;
    return pattern_value(fringes, p, x);
  };
  const double expected[4][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  for (int word = 0; word < 4; ++word) {
    for (const double within : {0.0, 5.0, 9.999999}) {  // [start, end)
      EXPECT_EQ(value(0, 10 * word + within), expected[word][0]) << word;
      EXPECT_EQ(value(1, 10 * word + within), expected[word][1]) << word;
    }
  }
}

TEST(Fringes, ComplementaryChangesInMidWordOnly) {
  GrayCode gray;
  gray.bits = 3;
  gray.complementary = true;
  const Fringes fringes = gray_fringes(10, gray);
  // last bit of the half-period code: 0 1 1 0 0 1 1 0 ...: constant across a word's border
  for (int j = 0; j < 16; ++j)
    EXPECT_EQ(complementary(fringes, 5 * j + 2.5), ((j % 4) == 1 || (j % 4) == 2) ? 1.0 : 0.0) << j;
}

TEST(Fringes, OffsetAndOriginShiftTheWords) {
  GrayCode gray;
  gray.bits = 6;
  gray.offset_periods = 0.5;
  const Fringes fringes = gray_fringes(16, gray, 0, 3.0);
  for (int k = 0; k < 64; ++k) {  // [origin + (k + offset) pitch, origin + (k + 1 + offset) pitch)
    const double start = 3.0 + (k + 0.5) * 16;
    EXPECT_EQ(decode_word(fringes, start), k);
    EXPECT_EQ(decode_word(fringes, start + 15.99), k);
    EXPECT_EQ(decode_word(fringes, start - 0.01), (k + 63) % 64);
  }
}

TEST(Fringes, WordsOutsideTheCodeWrap) {
  GrayCode gray;
  gray.bits = 3;
  const Fringes fringes = gray_fringes(10, gray);
  EXPECT_EQ(decode_word(fringes, 85), 0);
  EXPECT_EQ(decode_word(fringes, -0.25), 7);
  EXPECT_EQ(decode_word(fringes, -81), 7);
  EXPECT_EQ(decode_word(fringes, 1e6 + 15), (100001 % 8));
}

// A pixel reaches from half a pixel before its centre to half a pixel behind it; the border pixels go on.
TEST(Fringes, LevelsOfAnImageAreThoseOfThePixelThatHoldsThePlace) {
  ImageF levels(3, 2);
  for (std::size_t i = 0; i < levels.size(); ++i) levels.data[i] = 0.125F * static_cast<float>(i);
  const auto level = [&](double x_px, double y_px) { return image_level(levels, x_px, y_px); };
  const auto of = [&](int x, int y) { return static_cast<double>(levels(x, y)); };
  EXPECT_EQ(level(0.0, 0.0), of(0, 0));
  EXPECT_EQ(level(0.49, 0.49), of(0, 0));
  EXPECT_EQ(level(0.51, 0.49), of(1, 0));
  EXPECT_EQ(level(0.49, 0.51), of(0, 1));
  EXPECT_EQ(level(1.6, 0.9), of(2, 1));
  EXPECT_EQ(level(-9.0, 0.0), of(0, 0));
  EXPECT_EQ(level(1.0, -9.0), of(1, 0));
  EXPECT_EQ(level(9.0, 9.0), of(2, 1));
}

TEST(Fringes, FinestPitch) {
  const DirectionFringes direction{Axis::y, {64, 16, 32}, {0, 0, 0}, {}};
  EXPECT_EQ(direction.finest(), 1);
  EXPECT_THROW(DirectionFringes{}.finest(), std::logic_error);
}

TEST(Fringes, GrayPatternWithoutGrayCodeIsAProgrammingFault) {
  Fringes fringes;
  fringes.directions = {{Axis::x, {13}, {0}, {}}};
  PatternSpec p;
  p.kind = Kind::gray_bit;
  EXPECT_THROW(pattern_value(fringes, p, 1.0), std::logic_error);
}

RC_GTEST_PROP(FringesProperty, WordsDecodeToTheirPlace, ()) {
  GrayCode gray;
  gray.bits = *rc::gen::resize(100, rc::gen::inRange(1, 12));
  gray.offset_periods = *testing::uniform(-2.0, 2.0);
  const double pitch = *testing::uniform(2.0, 40.0), origin = *testing::uniform(-20.0, 20.0);
  const Fringes fringes = gray_fringes(pitch, gray, 0, origin);
  const int words = 1 << gray.bits;
  const int k = *rc::gen::resize(100, rc::gen::inRange(0, words));
  const double within = *testing::uniform(0.001, 0.999);  // off the border, where rounding decides
  RC_ASSERT(decode_word(fringes, origin + (k + within + gray.offset_periods) * pitch) == k);
}

RC_GTEST_PROP(FringesProperty, HalfPeriodCodeTellsTheHalf, ()) {
  GrayCode gray;
  gray.bits = *rc::gen::resize(100, rc::gen::inRange(1, 10));
  gray.complementary = true;
  gray.offset_periods = *testing::uniform(-2.0, 2.0);
  const Fringes fringes = gray_fringes(18, gray);
  const int j = *rc::gen::resize(100, rc::gen::inRange(0, 2 << gray.bits));
  const double x = (0.5 * (j + *testing::uniform(0.001, 0.999)) + gray.offset_periods) * 18;
  // the (bits+1)-bit code of half periods: its upper bits are those of the word
  const int binary_last = (decode_word(fringes, x) & 1) ^ static_cast<int>(complementary(fringes, x));
  RC_ASSERT(decode_word(fringes, x) * 2 + binary_last == j);
}

}  // namespace
}  // namespace fringetwin::fringes_test
