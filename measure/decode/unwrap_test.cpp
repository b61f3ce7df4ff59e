// SPDX-License-Identifier: Apache-2.0
// | check                                    | tolerance       | unit | origin |
// |------------------------------------------|-----------------|------|---------------------------------------|
// | heterodyne, Gaussian phase noise 0.05 rad| 0.3             | % wrong or rejected | first stage at 3.4
// sigma: 0.07 % | | heterodyne within plan.tolerance_rad     | 1               | %    | 3 sigma at the
// weakest stage: 0.3 %   | | heterodyne, bounded error of the phases  | 0 wrong         | -    | 0.5 order /
// sum of |coefficients|     | | hierarchical, noise at half the gate     | 0 wrong         | -    | stage
// error < 0.3 cycles              | | Gray orders                              | 0 wrong         | -    |
// exact code, edges within a quarter period |
#include "measure/decode/unwrap.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::unwrap_test {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

float wrapped(double x_px, double pitch_px, double origin_px, double error_rad = 0.0) {
  double phase = std::remainder(kTwoPi * (x_px - origin_px) / pitch_px + error_rad, kTwoPi);
  if (phase <= -std::numbers::pi) phase = std::numbers::pi;
  return std::min(static_cast<float>(phase), 3.1415925f);
}

DirectionFringes direction(std::vector<double> pitches, std::vector<double> origins) {
  DirectionFringes d;
  d.pitches_px = std::move(pitches);
  d.phase_origin_px = std::move(origins);
  return d;
}

struct Score {
  int wrong = 0, rejected = 0;
  double worst_px = 0.0;
};

/// Unwraps n random coordinates of the range with the phase errors that `error_rad` draws.
template <class Error>
Score score_heterodyne(const DirectionFringes& d, CoordinateRange range, int n, unsigned seed,
                       Error error_rad) {
  const HeterodynePlan plan = plan_heterodyne(d, range);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> position(range.begin, range.end);
  std::vector<double> truth(static_cast<std::size_t>(n)), x(truth.size());
  std::vector<float> phase[3], variance(truth.size(), 1e-4f), variance_px2(truth.size());
  for (auto& p : phase) p.resize(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i] = position(random);
    for (int k = 0; k < 3; ++k)
      phase[k][i] = wrapped(truth[i], plan.pitch_px[k], plan.origin_px[k], error_rad(random));
  }
  const PitchRow rows[3] = {{phase[0].data(), variance.data()},
                            {phase[1].data(), variance.data()},
                            {phase[2].data(), variance.data()}};
  unwrap_heterodyne_row(plan, rows, n, x.data(), variance_px2.data());
  Score s;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double e = std::fabs(x[i] - truth[i]);
    if (std::isnan(e))
      ++s.rejected;
    else if (e > 0.25 * plan.pitch_px[0])
      ++s.wrong;
    else
      s.worst_px = std::max(s.worst_px, e);
  }
  return s;
}

TEST(Heterodyne, StagesOfThirteenFourteenFifteen) {
  CoordinateRange range{-0.5, 1279.5, true};
  const HeterodynePlan p = plan_heterodyne(direction({14, 15, 13}, {0, 0, 0}), range);
  EXPECT_EQ(p.index[0], 2);
  EXPECT_NEAR(p.beat12_px, 182.0, 1e-9);
  EXPECT_NEAR(p.beat23_px, 210.0, 1e-9);
  EXPECT_NEAR(p.synthetic_px, 1365.0, 1e-6);
  EXPECT_GT(p.tolerance_rad, 0.05);
  EXPECT_LT(p.tolerance_rad, 0.08);
}

TEST(Heterodyne, ToleratesFiveHundredthsOfARadian) {
  std::normal_distribution<double> normal(0.0, 0.05);
  const Score s = score_heterodyne(direction({13, 14, 15}, {0, 0, 0}), {-0.5, 1279.5, true}, 200000, 1,
                                   [&](std::mt19937& r) { return normal(r); });
  EXPECT_LE(s.wrong + s.rejected, 600);
  EXPECT_LE(s.wrong, 100);  // unnoticed: 195 px = 15 x 13 = 13 x 15 fits but for 1 px at pitch 14
}

TEST(Heterodyne, NoiseFreeIsExactOverTheWholeSyntheticPeriod) {
  const Score s = score_heterodyne(direction({13, 14, 15}, {3.25, -7.5, 40.0}), {}, 100000, 2,
                                   [](std::mt19937&) { return 0.0; });
  EXPECT_EQ(s.wrong + s.rejected, 0);
  EXPECT_LT(s.worst_px, 2e-6);  // 13 px/2pi * 4e-7 rad
}

RC_GTEST_PROP(Heterodyne, RandomPitchesAndOriginsWithinTheirTolerance, ()) {
  // Pitches like 13/14/15: neighbouring, double beat finite.
  const double p1 = *rc::gen::inRange(80, 400) / 10.0;
  const double p2 = p1 * (1.0 + *rc::gen::inRange(40, 90) / 1000.0);
  const double p3 = p2 * (1.0 + *rc::gen::inRange(40, 90) / 1000.0);
  const double f = std::fabs(1.0 / p1 - 2.0 / p2 + 1.0 / p3);
  RC_PRE(f > 1.0 / 4000.0);
  std::vector<double> origins;
  for (int i = 0; i < 3; ++i) origins.push_back(*rc::gen::inRange(-20000, 20000) / 10.0);
  CoordinateRange range{-0.5, std::floor(0.85 / f), true};  // 13/14/15 on 1280 px: 0.94
  RC_PRE(range.size() > 4.0 * p3);
  const DirectionFringes d = direction({p1, p2, p3}, origins);
  const double sigma = std::min(0.1, plan_heterodyne(d, range).tolerance_rad);
  RC_PRE(sigma > 1e-3);
  std::normal_distribution<double> normal(0.0, sigma);
  const Score s = score_heterodyne(d, range, 2000, *rc::gen::arbitrary<unsigned>(),
                                   [&](std::mt19937& r) { return normal(r); });
  // Besides noise, coordinates just inside the range may leave it.
  const double at_ends = 2.0 * sigma / kTwoPi * p3 / range.size();
  RC_ASSERT(s.wrong + s.rejected <= 50 + static_cast<int>(2000.0 * at_ends));
}

TEST(Heterodyne, RefusesWhatItCannotUnwrap) {
  const auto message = [](const DirectionFringes& d, CoordinateRange range) -> std::string {
    try {
      plan_heterodyne(d, range);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::usage);
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message(direction({13, 14}, {0, 0}), {}).find("three pitches"), std::string::npos);
  EXPECT_NE(message(direction({13, 14, 14}, {0, 0, 0}), {}).find("differ"), std::string::npos);
  const std::string cover = message(direction({13, 14, 15}, {0, 0, 0}), {-0.5, 1919.5, true});
  EXPECT_NE(cover.find("1365"), std::string::npos) << cover;
  EXPECT_NE(cover.find("1920"), std::string::npos) << cover;
  // Equal beats have no double beat.
  EXPECT_NE(message(direction({12, 15, 20}, {0, 0, 0}), {-0.5, 639.5, true}), "");
}

TEST(Hierarchical, CoarsestMustCoverTheProjector) {
  CoordinateRange range{-0.5, 1023.5, true};
  EXPECT_THROW(plan_hierarchical(direction({1000, 100}, {0, 0}), range), UserError);
  EXPECT_NO_THROW(plan_hierarchical(direction({64, 1024, 256}, {0, 0, 0}), range));
}

RC_GTEST_PROP(Hierarchical, AnyOrderAnyOrigin, ()) {
  const double size = *rc::gen::inRange(600, 2000);
  std::vector<double> pitches = {size};
  while (pitches.back() > 12.0 && pitches.size() < 6)
    pitches.push_back(pitches.back() / (*rc::gen::inRange(20, 60) / 10.0));
  std::vector<double> origins;
  for (std::size_t i = 0; i < pitches.size(); ++i) origins.push_back(*rc::gen::inRange(-3000, 3000) / 7.0);
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  std::shuffle(pitches.begin(), pitches.end(), random);
  CoordinateRange range{-0.5, size - 0.5, true};
  const HierarchicalPlan plan = plan_hierarchical(direction(pitches, origins), range);
  // Bounded error e: a stage of ratio r sees e (1 + r) / 2pi cycles, less than 0.29 for r <= 6.
  std::uniform_real_distribution<double> position(range.begin + 0.05 * size, range.end - 0.05 * size),
      error(-0.25, 0.25);
  constexpr int kN = 500;
  std::vector<double> truth(kN), x(kN);
  std::vector<std::vector<float>> phase(plan.index.size(), std::vector<float>(kN));
  std::vector<float> variance(kN, 1e-4f), variance_px2(kN);
  std::vector<PitchRow> rows;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i] = position(random);
    for (std::size_t k = 0; k < phase.size(); ++k)
      phase[k][i] = wrapped(truth[i], plan.pitch_px[k], plan.origin_px[k], error(random));
  }
  for (const auto& p : phase) rows.push_back({p.data(), variance.data()});
  unwrap_hierarchical_row(plan, rows, kN, x.data(), variance_px2.data());
  for (std::size_t i = 0; i < truth.size(); ++i)
    RC_ASSERT(std::fabs(x[i] - truth[i]) < plan.pitch_px.back() * 0.26 / kTwoPi + 1e-3);
}

TEST(Hierarchical, DoubtfulOrderIsRejected) {
  CoordinateRange range{-0.5, 99.5, true};
  const HierarchicalPlan plan = plan_hierarchical(direction({100, 10}, {0, 0}), range);
  // The fine phase contradicts the coarse one by 0.4 cycles.
  const float coarse = wrapped(50.0, 100, 0), fine = wrapped(54.0, 10, 0), variance = 1e-4f;
  double x = 0.0;
  float variance_px2 = 0.0f;
  unwrap_hierarchical_row(plan, {{&coarse, &variance}, {&fine, &variance}}, 1, &x, &variance_px2);
  EXPECT_TRUE(std::isnan(x));
}

/// Code images of one coordinate with the edges moved by shift_px (blur, response, other exposure).
struct CodePixel {
  std::vector<float> values;
  GrayRow row;
};
CodePixel code_pixel(const GrayPlan& plan, double x_px, double shift_px, double footprint_px) {
  Fringes f;
  f.steps = 4;
  f.unwrap = Unwrap::gray;
  f.directions = {direction({plan.pitch_px}, {plan.origin_px})};
  GrayCode code;
  code.bits = plan.bits;
  code.offset_periods = plan.offset_periods;
  code.complementary = plan.complementary;
  f.directions[0].gray = code;
  CodePixel p;
  const auto value = [&](PatternSpec::Kind kind, int bit) {
    PatternSpec s;
    s.kind = kind;
    s.bit = bit;
    double sum = 0.0;
    for (int i = 0; i < 32; ++i)
      sum += pattern_value(f, s, x_px + shift_px + footprint_px * ((i + 0.5) / 32.0 - 0.5));
    return static_cast<float>(10.0 + 200.0 * sum / 32.0);
  };
  p.values.reserve(32);
  for (int b = 0; b < plan.bits; ++b) {
    p.values.push_back(value(PatternSpec::Kind::gray_bit, b));
    p.row.bits.push_back(&p.values.back());
  }
  if (plan.complementary) {
    p.values.push_back(value(PatternSpec::Kind::complementary, plan.bits));
    p.row.complementary = &p.values.back();
  }
  return p;
}

double decode_pixel(const GrayPlan& plan, double x_px, double phase_error_rad, double shift_px,
                    double footprint_px) {
  const CodePixel pixel = code_pixel(plan, x_px, shift_px, footprint_px);
  const float threshold = 110.0f, amplitude = 100.0f, variance = 1e-4f;
  const float phase = wrapped(x_px, plan.pitch_px, plan.origin_px, phase_error_rad);
  GrayScratch scratch;
  double x = 0.0;
  float variance_px2 = 0.0f;
  read_gray_row(plan, pixel.row, &threshold, 1, scratch);
  unwrap_gray_row(plan, {&phase, &variance}, &amplitude, 1, scratch, &x, &variance_px2);
  return x;
}

RC_GTEST_PROP(Gray, ComplementaryBitBearsEdgesAQuarterPeriodOff, ()) {
  GrayPlan plan;
  plan.bits = *rc::gen::inRange(2, 9);
  plan.pitch_px = *rc::gen::inRange(80, 900) / 10.0;
  plan.origin_px = *rc::gen::inRange(-5000, 5000) / 10.0;
  plan.offset_periods = *rc::gen::inRange(-20, 21) / 20.0;
  plan.complementary = true;
  const double begin = plan.origin_px + plan.offset_periods * plan.pitch_px;
  const double span = plan.pitch_px * std::ldexp(1.0, plan.bits);
  const double f = *rc::gen::inRange(0, 100001) / 100000.0;
  const double x = begin + plan.pitch_px + f * (span - 2.0 * plan.pitch_px);
  const double shift = *rc::gen::inRange(-99, 100) / 100.0 * 0.23 * plan.pitch_px;
  const double error = *rc::gen::inRange(-10, 11) / 100.0;  // rad
  RC_ASSERT(std::fabs(decode_pixel(plan, x, error, shift, 0.0) - x) < 0.02 * plan.pitch_px);
}

RC_GTEST_PROP(Gray, UnsettledBitsTellTheNearEdge, ()) {
  GrayPlan plan;
  plan.bits = *rc::gen::inRange(2, 9);
  plan.pitch_px = *rc::gen::inRange(160, 900) / 10.0;
  plan.origin_px = *rc::gen::inRange(-5000, 5000) / 10.0;
  plan.offset_periods = *rc::gen::inRange(-20, 21) / 20.0;
  const double begin = plan.origin_px + plan.offset_periods * plan.pitch_px;
  const double span = plan.pitch_px * std::ldexp(1.0, plan.bits);
  const double f = *rc::gen::inRange(0, 100001) / 100000.0;
  const double x = begin + plan.pitch_px + f * (span - 2.0 * plan.pitch_px);
  // Code and phase disagree by less than a quarter of the footprint.
  const double footprint = 0.1 * plan.pitch_px;
  const double shift = *rc::gen::inRange(-99, 100) / 100.0 * 0.12 * footprint;
  const double error = *rc::gen::inRange(-99, 100) / 100.0 * 0.12 * footprint / plan.pitch_px * kTwoPi;
  RC_ASSERT(std::fabs(decode_pixel(plan, x, error, shift, footprint) - x) < 0.02 * plan.pitch_px);
}

TEST(Gray, CodeRepeatsOutsideAndIsBroughtBackIntoTheProjector) {
  // slmaster: 32 words of 60 px from column 0; columns -0.5 ... 0 read the last word.
  DirectionFringes d = direction({60}, {30});
  d.gray = GrayCode{5, false, true, -0.5, GrayCode::Threshold::mean};
  const GrayPlan plan = plan_gray(d, 12, {-0.5, 1919.5, true});
  for (const double x : {-0.49, -0.1, 0.0, 0.1, 59.9, 60.0, 60.1, 1919.0, 1919.49})
    EXPECT_NEAR(decode_pixel(plan, x, 0.0, 0.0, 0.0), x, 1e-4);
}

TEST(Gray, RefusesWhatItCannotDecode) {
  DirectionFringes d = direction({60}, {30});
  EXPECT_THROW(plan_gray(d, 12, {}), UserError);  // no code
  d.gray = GrayCode{5, false, false, 0.0, GrayCode::Threshold::mean};
  EXPECT_NO_THROW(plan_gray(d, 12, {}));
  EXPECT_THROW(plan_gray(d, 0, {}), UserError);                     // mean of no steps
  EXPECT_THROW(plan_gray(d, 12, {-0.5, 1920.5, true}), UserError);  // 1920 px do not cover 1921
  d.pitches_px = {60, 30};
  d.phase_origin_px = {30, 30};
  EXPECT_THROW(plan_gray(d, 12, {}), UserError);  // two pitches
}

}  // namespace
}  // namespace fringetwin::measure::unwrap_test
