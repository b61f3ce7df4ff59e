// SPDX-License-Identifier: Apache-2.0
// Truth: images formed from a formula with a known 5th harmonic, brightness and noise, decoded by measure/.
// clang-format off
// | check                 | tolerance   | origin                                                                  |
// |-----------------------|-------------|-------------------------------------------------------------------------|
// | ripple amplitude      | 3 %         | 2 h5/B of first order in h5/B = 0.046: next order 0.1 %; noise          |
// | brightness part       | 5 %         | first order in 2 % of one image                                         |
// | noise part            | 3 %         | predicted sigma against the noise put in, 4e4 pixels                    |
// | explained share       | > 0.95      | nothing else was put in                                                 |
// | offset put in         | 1e-3 rad    | mean of 4e4 pixels                                                      |
// | slow part             | 4 %         | block means keep sinc^2 of it                                           |
// | chi2 of a ripple      | 18          | 3 times 2 sqrt(138)/4, the scatter of a noncentral chi2 of 138, over 4  |
// | chi2 without one      | < 4.5       | 1 + 5 sqrt(2/4): one right number in 800 is beyond                      |
// | parts' sum            | 1e-12 rad^2 | by construction                                                         |
// clang-format on
#include "compare/phase/phase_budget.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "measure/decode/decode.hpp"
#include "measure/decode/phase.hpp"

namespace fringetwin::compare::phase_budget_test {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr int kWidth = 240, kHeight = 180;
constexpr double kPitch = 60.0, kAmplitude = 46.3;

struct Bench {
  Twin twin;
  double noise_dn = 0.6, fifth_dn = 2.14, eleventh_dn = 0.0;
  double flicker = 0.0;  ///< step 3 is brighter by this share
  double per_px = 2.3;   ///< columns of the projector
  unsigned seed = 3;

  Bench() {
    DirectionFringes x;
    x.pitches_px = {kPitch};
    x.phase_origin_px = {30.0};
    x.gray = GrayCode{5, false, true, -0.5, GrayCode::Threshold::mean};
    twin.fringes.directions = {x};
    twin.fringes.steps = 12;
    twin.fringes.unwrap = Unwrap::gray;
  }
  double column(int x, int y) const { return 200.0 + per_px * x + 0.15 * y; }

  /// Decoded from `steps` of twelve images with the harmonic and noise.
  measure::DirectionDecode decoded(const std::vector<int>& steps, double shift_px = 0.0) {
    std::mt19937_64 random(seed++);
    std::normal_distribution<double> normal;
    CameraImages images;
    images.camera = "camera";
    images.radiance = false;
    for (const PatternSpec& spec : expand_sequence(twin.fringes)) {
      ImageF image(kWidth, kHeight);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const double c = column(x, y) + shift_px;
          double v = 119.0;
          if (spec.is_gray()) {
            v += 60.0 * (2.0 * pattern_value(twin.fringes, spec, c) - 1.0);
          } else {
            const double theta = kTwoPi * ((c - 30.0) / kPitch + spec.step / 12.0);
            v += kAmplitude * std::cos(theta) + fifth_dn * std::cos(5.0 * theta) +
                 eleventh_dn * std::cos(11.0 * theta);
            v = v * (1.0 + (spec.step == 3 ? flicker : 0.0)) + noise_dn * normal(random);
          }
          image(x, y) = static_cast<float>(v);
        }
      images.images.push_back(std::move(image));
    }
    measure::DecodeOptions options;
    options.use_steps = steps;
    options.projector_width_px = 1920.0;
    options.variance_offset_dn2 = noise_dn * noise_dn - 1.0 / 12.0;  // nothing is rounded here
    return measure::decode(images, twin.fringes, options).directions.at(0);
  }
};

const std::vector<int> kEven = {0, 2, 4, 6, 8, 10}, kOdd = {1, 3, 5, 7, 9, 11};

void expect_sum(const PhaseBudget& b) {
  EXPECT_NEAR(b.offset_rad2 + b.brightness_rad2 + b.harmonic_rad2 + b.noise_rad2 + b.low_frequency_rad2 +
                  b.high_frequency_rad2,
              b.total_rad2, 1e-12);
}

TEST(PhaseBudget, AliasOrder) {
  EXPECT_EQ(alias_order({0, 1, 2, 3}, 4), 4);
  EXPECT_EQ(alias_order(kEven, 12), 6);
  EXPECT_EQ(alias_order(kOdd, 12), 6);
  EXPECT_EQ(alias_order({2, 5, 8, 11}, 12), 4);
  EXPECT_EQ(alias_order({0, 2, 4}, 5), 1);      // unequal gaps: every order leaks
  EXPECT_EQ(alias_order({0, 1, 2, 3}, 12), 1);  // a part of the period only
}

TEST(PhaseBudget, FifthHarmonicShowsTwiceInEvenAgainstOddSteps) {
  Bench bench;
  const auto even = bench.decoded(kEven), odd = bench.decoded(kOdd);
  const auto b = phase_budget(bench.twin, odd, even, kOdd);
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(b->alias_order, 6);
  const double amplitude = 2.0 * bench.fifth_dn / kAmplitude;  // 0.0924 rad: rms 0.0654
  EXPECT_NEAR(b->harmonic_amplitude_rad, amplitude, 0.03 * amplitude);
  EXPECT_NEAR(std::sqrt(b->harmonic_rad2), amplitude / std::sqrt(2.0), 0.03 * amplitude);
  const double noise = 2.0 * (2.0 / 6.0) * std::pow(bench.noise_dn / kAmplitude, 2);
  EXPECT_NEAR(b->noise_rad2, noise, 0.03 * noise);
  EXPECT_GT(b->explained(), 0.95);
  EXPECT_NEAR(b->low_frequency_rad2 / b->total_rad2, 0.0, 0.02);
  expect_sum(*b);
}

TEST(PhaseBudget, SameStepsShareTheHarmonic) {
  Bench bench;
  const auto a = bench.decoded(kOdd), c = bench.decoded(kOdd);
  const auto b = phase_budget(bench.twin, a, c, kOdd);
  ASSERT_TRUE(b.has_value());
  EXPECT_LT(b->harmonic_rad2, 0.01 * b->total_rad2);
  EXPECT_GT(b->explained(), 0.95);
  expect_sum(*b);
}

TEST(PhaseBudget, OneBrighterImageIsCalledBrightness) {
  Bench bench;
  bench.fifth_dn = 0.0;
  bench.flicker = 0.02;
  const auto even = bench.decoded(kEven), odd = bench.decoded(kOdd);  // step 3 is an odd one
  const auto b = phase_budget(bench.twin, odd, even, kOdd);
  ASSERT_TRUE(b.has_value());
  // first order: the error is 2/(6 B) e (A + B cos(phi + d)) sin(phi + d): order 1 of amplitude e A/(3 B),
  // order 2 of e/6
  const double e = bench.flicker, order1 = e * 119.0 / (3.0 * kAmplitude), order2 = e / 6.0;
  EXPECT_NEAR(b->brightness_rad2, 0.5 * (order1 * order1 + order2 * order2), 0.05 * 0.5 * order1 * order1);
  EXPECT_LT(b->harmonic_rad2, 0.01 * b->total_rad2);
  EXPECT_GT(b->explained(), 0.95);
  expect_sum(*b);
}

TEST(PhaseBudget, OffsetAndSlowErrorsHaveTheirOwnRows) {
  Bench bench;
  bench.fifth_dn = 0.0;
  const auto a = bench.decoded(kEven);
  auto c = bench.decoded(kOdd);
  const double offset_rad = 0.02, slow_rad = 0.03;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      c.coordinate_px(x, y) +=
          kPitch / kTwoPi * (offset_rad + slow_rad * std::sin(kTwoPi * y / (0.5 * kHeight)));
  const auto b = phase_budget(bench.twin, a, c, kOdd);
  ASSERT_TRUE(b.has_value());
  EXPECT_NEAR(std::sqrt(b->offset_rad2), offset_rad, 1e-3);
  // block means over 16 of 90 px keep sinc^2(16/90) = 0.90 of it
  EXPECT_NEAR(b->low_frequency_rad2, 0.90 * 0.5 * slow_rad * slow_rad, 0.04 * 0.5 * slow_rad * slow_rad);
  EXPECT_LT(b->explained(), 0.6);
  expect_sum(*b);
}

TEST(PhaseBudget, FewPixelsOrNoStepsHaveNone) {
  Bench bench;
  auto a = bench.decoded(kEven);
  const auto c = bench.decoded(kOdd);
  for (std::size_t i = 900; i < a.coordinate_px.size(); ++i) a.coordinate_px.data[i] = std::nan("");
  EXPECT_FALSE(phase_budget(bench.twin, a, c, kOdd).has_value());
  bench.twin.fringes.steps = 0;
  EXPECT_FALSE(phase_budget(bench.twin, c, c, {}).has_value());
}

/// Both sides are decoded from `steps`, with noise of their own; the real one has the fault.
RippleTest ripple_between(Bench real, const std::vector<int>& steps) {
  Bench simulated;
  simulated.per_px = real.per_px;
  simulated.fifth_dn = 0.0;
  simulated.seed = 11;
  const measure::DirectionDecode a = real.decoded(steps), b = simulated.decoded(steps);
  ImageU8 interior(kWidth, kHeight, 0);
  for (int y = 2; y < kHeight - 2; ++y)
    for (int x = 2; x < kWidth - 2; ++x) interior(x, y) = 1;
  return test_ripple(real.twin, a, b, steps, interior, texture_shift(a, b)).value();
}

TEST(RippleTest, NoiseTakesOneAFunction) {
  Bench right;
  right.fifth_dn = 0.0;
  const RippleTest t = ripple_between(right, kEven);
  EXPECT_EQ(t.functions, 4);
  EXPECT_EQ(t.order, 6);
  EXPECT_LT(t.brightness_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
  EXPECT_LT(t.harmonic_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
  // 2/6 (0.6 DN)^2 / (46.3 DN)^2 on each side, 41,536 pixels
  EXPECT_NEAR(t.information / (41'536.0 / (2.0 * 2.0 / 6.0 * std::pow(0.6 / kAmplitude, 2))), 1.0, 0.03);
}

// Phases of a fringe with a strong harmonic crowd where it makes them slow: at the place that the noisy side
// tells, noise of 0.04 rad by itself would ripple by 3 mrad there, 15 to 30 times what chance makes of it.
TEST(RippleTest, NoiseOnFringesThatRippleIsNone) {
  for (const double simulated_noise_dn : {3.0, 0.5}) {
    Bench real, simulated;
    real.fifth_dn = simulated.fifth_dn = 4.0;
    real.noise_dn = 3.0;
    simulated.noise_dn = simulated_noise_dn;
    simulated.seed = 11;
    const measure::DirectionDecode a = real.decoded(kOdd), b = simulated.decoded(kOdd);
    const ImageU8 interior(kWidth, kHeight, 1);
    const RippleTest t = test_ripple(real.twin, a, b, kOdd, interior, texture_shift(a, b)).value();
    EXPECT_LT(t.harmonic_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
    EXPECT_LT(t.brightness_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
    real.fifth_dn = 4.1;  // 2 mrad more are seen
    const RippleTest more =
        test_ripple(real.twin, real.decoded(kOdd), b, kOdd, interior, texture_shift(a, b)).value();
    EXPECT_GT(more.harmonic_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
  }
}

// A fringe of 26 camera pixels, of which a ripple of 6 per fringe is told from fringes that lie elsewhere. Of
// fringes of 6.1 pixels the camera sees a ripple of 6 per fringe as one of 60 pixels: as slow as a shift of
// the fringes may be, and only a shift is here, 20 times the noise of a pixel.
TEST(RippleTest, FringesThatLieElsewhereAreNone) {
  for (const double per_px : {2.3, kPitch / 6.1}) {
    Bench real, simulated;
    real.per_px = simulated.per_px = per_px;
    real.fifth_dn = simulated.fifth_dn = 0.0;
    simulated.seed = 11;
    const measure::DirectionDecode a = real.decoded(kEven);
    measure::DirectionDecode b = simulated.decoded(kEven);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double u = 2.0 * x / kWidth - 1.0, v = 2.0 * y / kHeight - 1.0;
        b.coordinate_px(x, y) += kPitch / kTwoPi * 0.2 * (u + 0.5 * v * v - 0.5 * u * v);
      }
    const ImageU8 interior(kWidth, kHeight, 1);
    const RippleTest t = test_ripple(real.twin, a, b, kEven, interior, texture_shift(a, b)).value();
    EXPECT_LT(t.harmonic_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0)) << per_px;
    EXPECT_LT(t.brightness_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0)) << per_px;
  }
}

// Fringes of 150 camera pixels, of which the image holds hardly two, and noise of a pixel that is larger than
// what the fringe turns by from one to the next: an image that is too bright is seen there as well.
TEST(RippleTest, AnImageThatIsTooBrightIsSeenOnWideFringes) {
  for (const double per_px : {2.3, 0.4}) {
    Bench wrong;
    wrong.per_px = per_px;
    wrong.noise_dn = 3.0;
    wrong.fifth_dn = 0.0;
    wrong.flicker = 0.02;  // ten times that of the next test, for five times its noise
    const RippleTest t = ripple_between(wrong, measure::all_steps(12));
    EXPECT_GT(t.brightness_chi2, 2.0 * (1.0 + 5.0 * std::sqrt(2.0 / 4.0))) << per_px;
    EXPECT_LT(t.harmonic_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0)) << per_px;
  }
}

// 2700 pixels, 15 in a row of each block of 16 x 16, do not tell what is smooth in it: that is no test, and
// no agreement. Two such rows are one.
TEST(RippleTest, TooFewPixelsInEachBlockAreNone) {
  Bench real, simulated;
  real.per_px = simulated.per_px = kPitch / 6.1;
  simulated.seed = 11;
  const measure::DirectionDecode a = real.decoded(kEven), b = simulated.decoded(kEven);
  for (const int n_rows : {1, 2}) {
    ImageU8 interior(kWidth, kHeight, 0);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) interior(x, y) = x % 16 < 15 && y % 16 < n_rows ? 1 : 0;
    EXPECT_EQ(test_ripple(real.twin, a, b, kEven, interior, texture_shift(a, b)).has_value(), n_rows == 2);
  }
}

TEST(RippleTest, AHarmonicFarBelowTheNoiseOfAPixelIsSeen) {
  Bench wrong;
  wrong.fifth_dn = 0.04;  // ripple of 0.04/46.3 rad = 0.08 of the noise of a pixel of the difference
  const RippleTest t = ripple_between(wrong, kEven);
  // n a^2/2 over sigma^2, on one of four functions' pairs: 41,536 * (8.6e-4)^2 / 2 / (1.06e-2)^2 / 4
  EXPECT_NEAR(t.harmonic_chi2, 1.0 + 34.5, 18.0);
  EXPECT_LT(t.brightness_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
}

TEST(RippleTest, NamesTheLargerOrder) {
  Bench wrong;
  wrong.fifth_dn = 0.1;
  EXPECT_EQ(ripple_between(wrong, kEven).strongest, 6);
  wrong.eleventh_dn = 0.2;
  EXPECT_EQ(ripple_between(wrong, kEven).strongest, 12);
}

TEST(RippleTest, AnImageThatIsALittleTooBrightIsSeen) {
  Bench wrong;
  wrong.fifth_dn = 0.0;
  std::vector<int> all(12);
  for (int i = 0; i < 12; ++i) all[static_cast<std::size_t>(i)] = i;
  wrong.flicker = 0.002;
  const RippleTest t = ripple_between(wrong, all);
  EXPECT_GT(t.brightness_chi2, 2.0 * (1.0 + 5.0 * std::sqrt(2.0 / 4.0)));
  EXPECT_LT(t.harmonic_chi2, 1.0 + 5.0 * std::sqrt(2.0 / 4.0));
}

// One of twelve images 2 % too bright: what its factor predicts is what the ripple has.
TEST(RippleTest, LightPredictsTheBrightness) {
  for (const std::vector<int>& steps : {measure::all_steps(12), kOdd}) {
    Bench real, simulated;
    real.fifth_dn = simulated.fifth_dn = 0.0;
    real.flicker = 0.02;
    simulated.seed = 11;
    const measure::DirectionDecode a = real.decoded(steps), b = simulated.decoded(steps);
    const Lens lens("LENSMODEL_PINHOLE", {900, 900, 119.5, 89.5}, {kWidth, kHeight}, "test");
    real.twin.cameras.push_back({"camera", lens, Pose{}, Sensor{}, std::nullopt});
    measure::LightFactors light;
    light.factor.assign(expand_sequence(real.twin.fringes).size(), 1.0);
    light.sigma.assign(light.factor.size(), 1e-3);
    light.factor[3] = 1.02;
    const double predicted = predicted_brightness_rad2(real.twin, 0, a, steps, light);
    EXPECT_NEAR(predicted / phase_budget(real.twin, a, b, steps)->brightness_rad2, 1.0, 0.05) << steps.size();
    real.twin.cameras[0].exposure_factors = light.factor;  // a twin that knows it
    EXPECT_EQ(predicted_brightness_rad2(real.twin, 0, a, steps, light), 0.0);
    EXPECT_TRUE(std::isnan(predicted_brightness_rad2(real.twin, 0, a, {0, 1, 2, 3}, light)));
    light.factor.assign(light.factor.size(), 1.0);
    light.sigma.assign(light.factor.size(), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(predicted_brightness_rad2(real.twin, 0, a, steps, light))) << "nobody knows them";
  }
}

}  // namespace
}  // namespace fringetwin::compare::phase_budget_test
