// SPDX-License-Identifier: Apache-2.0
// Verdicts on phases that differ by drawn noise, by an offset, by texture, and by ripples.
//
// | check                           | tolerance    | origin                                            |
// |---------------------------------|--------------|---------------------------------------------------|
// | chi2 of phase                   | 0.05         | scatter of a variance over 4e4 pixels is 0.007    |
// | regional chi2 of noise          | 3 sqrt(2/n)  | n blocks                                          |
// | chi2, a quarter on one side     | 0.02         | 4 standard errors, sqrt(2/n) 0.625, n = 40,000    |
// | limits                          | 1e-9         | rounding: closed forms                            |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "compare/verdict/explained.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::explain_phase_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

SidesTruth truth() {
  SidesTruth t = testing::deep_truth(60.0);
  t.width = 256;
  t.height = 240;
  t.pitches_px = {13};
  t.steps = 8;
  return t;
}

/// Decodes of the same surface, with Gaussian noise of a stated sigma on both sides and an offset.
struct Phases {
  measure::DirectionDecode real, simulated;
  ImageU8 interior;
};

Phases noisy_phases(double sigma_px, double offset_px, double noise_factor = 1.0) {
  SidesTruth t = truth();
  const SyntheticSides scene = testing::make_sides(t);
  Phases out{scene.real.measurement->cameras[0].directions[0],
             scene.simulated.measurement->cameras[0].directions[0],
             {}};
  out.interior = ImageU8(t.width, t.height, 0);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, sigma_px * noise_factor);
  for (measure::DirectionDecode* d : {&out.real, &out.simulated}) {
    d->finest = 0;
    d->coordinate_sigma_px = ImageF(t.width, t.height, static_cast<float>(sigma_px));
    for (double& x : d->coordinate_px.data) x += normal(random);
  }
  for (std::size_t i = 0; i < out.interior.size(); ++i)
    out.interior.data[i] = std::isnan(out.real.coordinate_px.data[i]) ? 0 : 1;
  for (double& x : out.simulated.coordinate_px.data) x += offset_px;
  return out;
}

ExplainedRow phase_of(const Phases& p, const RenderingError& rendering = {}) {
  return explain_phase("left", p.real, p.simulated, p.interior, texture_shift(p.real, p.simulated),
                       rendering);
}

constexpr double kSigmaPx = 0.01;
/// Of the difference's mean over a whole block of 16 x 16 px.
const double kRegionalSigmaPx = kSigmaPx * std::numbers::sqrt2 / 16.0;

TEST(ExplainPhase, PhaseNoiseAsStatedIsExplained) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 0.0));
  EXPECT_TRUE(row.explained());
  EXPECT_NEAR(row.chi2, 1.0, 0.05);
  EXPECT_NEAR(row.regional_chi2, 1.0, 3.0 * std::sqrt(2.0 / static_cast<double>(row.n_regions)));
  const double per_px = 2.0 * std::numbers::pi / 13.0;
  EXPECT_NEAR(row.expected() / (2.0 * std::pow(kSigmaPx * per_px, 2)), 1.0, 1e-3);
  EXPECT_EQ(row.region, "left x");
}

TEST(ExplainPhase, AConstantPhaseOffsetOfThreeRegionalSigmasIsNot) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 3.0 * kRegionalSigmaPx));
  EXPECT_LE(row.chi2, row.chi2_limit);        // no single pixel tells
  EXPECT_NEAR(row.regional_chi2, 10.0, 3.0);  // 1 + 9, less where a block is cut off by the disc
  EXPECT_FALSE(row.explained());
}

TEST(ExplainPhase, TooMuchPhaseNoiseIsNot) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 0.0, std::sqrt(1.3)));
  EXPECT_NEAR(row.chi2, 1.3, 0.05);
  EXPECT_FALSE(row.explained());
}

TEST(ExplainPhase, APhaseErrorOfTheRendererIsPartOfTheBudget) {
  const double per_px = 2.0 * std::numbers::pi / 13.0;
  RenderingError rendering;
  rendering.phase_rad = 3.0 * kRegionalSigmaPx * per_px;
  EXPECT_TRUE(phase_of(noisy_phases(kSigmaPx, 3.0 * kRegionalSigmaPx), rendering).explained());
}

TEST(ExplainPhase, TextureWithinAPixelMovesItsPhase) {
  // ln w rises by 0.3 a column over eight columns and falls over eight; each pixel sees its centroid
  Phases p = noisy_phases(kSigmaPx, 0.0);
  const auto log_weight = [](int x) { return 0.3 * std::abs(x % 16 - 8); };
  for (int y = 0; y < p.interior.height; ++y)
    for (int x = 1; x < p.interior.width - 1; ++x) {
      const double gradient = 0.5 * (log_weight(x + 1) - log_weight(x - 1));
      p.real.coordinate_px(x, y) += (0.83 + 2e-4 * y) * gradient / 12.0;  // as the coordinate was made
    }
  // up and down cancel in whole regions
  for (int y = 0; y < p.interior.height; y += 16)
    for (int x = 0; x < p.interior.width; x += 16) {
      int lit = 0;
      for (int k = 0; k < 256; ++k) lit += p.interior(x + k % 16, y + k / 16);
      for (int k = 0; k < 256 && lit < 256; ++k) p.interior(x + k % 16, y + k / 16) = 0;
    }
  EXPECT_EQ(phase_of(p).state, "not explained");  // no texture is seen
  for (int y = 0; y < p.interior.height; ++y)
    for (int x = 0; x < p.interior.width; ++x)
      p.real.amplitude_dn[0](x, y) *= static_cast<float>(std::exp(log_weight(x)));
  const ExplainedRow row = phase_of(p);
  EXPECT_EQ(row.state, "explained") << row.chi2 << " " << row.regional_chi2;
  EXPECT_GT(row.noise_chi2, 2.5);  // 1 + 14/16 (0.021/0.0141)^2
  EXPECT_EQ(row.lines.at(3).name, "texture within a pixel");
}

TEST(ExplainPhase, TooFewValuesAreNotCompared) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  std::size_t n = 0;
  for (unsigned char& m : p.interior.data) m = m != 0 && ++n <= 200 ? 1 : 0;
  EXPECT_TRUE(std::isfinite(phase_of(p).chi2));
  *std::find(p.interior.data.begin(), p.interior.data.end(), 1) = 0;
  const ExplainedRow row = phase_of(p);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_FALSE(row.explained());
  EXPECT_EQ(row.quantity, "phase");
  EXPECT_EQ(row.region, "left x");
  EXPECT_EQ(row.n, 199u);
  EXPECT_TRUE(std::isnan(row.chi2));
  EXPECT_TRUE(std::isnan(row.expected()));
  EXPECT_THAT(row.why, ::testing::HasSubstr("199 values"));
  p.real.unwrapped = false;
  EXPECT_THAT(phase_of(p).why, ::testing::HasSubstr("not unwrapped"));
}

TEST(ExplainPhase, OrdersThatDisagreeOnMostPixelsAreNotCompared) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  std::uint64_t lit = 0;
  for (const double x : p.real.coordinate_px.data) lit += std::isnan(x) ? 0 : 1;
  const SeenPixels seen{.both = lit, .either = lit};
  const auto row_with = [&](int from_column) {  // a period off to the right of it
    Phases q = p;
    for (int y = 0; y < q.real.coordinate_px.height; ++y)
      for (int x = from_column; x < q.real.coordinate_px.width; ++x) q.real.coordinate_px(x, y) += 13.0;
    return explain_phase("left", q.real, q.simulated, q.interior, texture_shift(q.real, q.simulated), {}, {},
                         seen);
  };
  EXPECT_EQ(row_with(140).state, "explained");
  const ExplainedRow row = row_with(116);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_LT(row.compared_fraction, 0.5);
}

TEST(ExplainPhase, TooLittlePhaseNoiseMakesTheBudgetTooWide) {
  // the simulated side has the noise that is stated, the real one half of it: chi2 (1 + 1/4)/2
  Phases p = noisy_phases(kSigmaPx, 0.0, 1e-6);
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal(0.0, kSigmaPx);
  for (double& x : p.real.coordinate_px.data) x += 0.5 * normal(random);
  for (double& x : p.simulated.coordinate_px.data) x += normal(random);
  p.real.noise_dn = p.simulated.noise_dn = 4.0;
  const ExplainedRow row = phase_of(p);
  EXPECT_NEAR(row.noise_chi2, 0.625, 0.02);
  EXPECT_EQ(row.state, "budget too wide");
  EXPECT_NEAR(row.too_wide_factor, 2.0, 0.2);  // from 2 * 0.625 - 1 +- 0.02
  p.real.noise_dn = 0.3;                       // hardly more than rounding
  EXPECT_EQ(phase_of(p).state, "explained");
}

TEST(ExplainPhase, ARippleBeyondNoiseIsNot) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  p.real.noise_dn = p.simulated.noise_dn = 4.0;
  const RippleTest noise{1.5, 0.5, 4, 4, 12, 1e8}, flicker{3.2, 0.5, 4, 4, 12, 1e8},
      waveform{1.5, 21.0, 2, 4, 12, 1e8};
  const auto judged = [&](const RippleTest& ripple, const RenderingError& rendering = {}) {
    ExplainedRow row = phase_of(p);
    judge_ripple(ripple, rendering, p.real, p.simulated, row);
    return row;
  };
  EXPECT_EQ(judged(noise).state, "explained");
  EXPECT_NEAR(judged(noise).ripple_limit, 1.0 + 5.0 / std::sqrt(6.0), 1e-12);
  EXPECT_EQ(judged(flicker).state, "not explained");
  EXPECT_THAT(judged(flicker).why, ::testing::HasSubstr("from image to image"));
  EXPECT_EQ(judged(waveform).state, "not explained");
  EXPECT_THAT(judged(waveform).why, ::testing::HasSubstr("ripples 4 times per fringe (21 times"));
  // an error of the renderer of 1e-3 rad may ripple: 1e-6 * 1e8 / 12 on top
  EXPECT_EQ(judged(flicker, {.gray_dn = 0.0, .phase_rad = 1e-3, .estimated = true}).state, "explained");
  p.real.noise_dn = 0.5;  // hardly more than rounding
  EXPECT_EQ(judged(waveform).state, "explained");
}

// What is known of the noise's variance, by its source, as docs/metrics/verdict.md states it: 5 % where it is
// stated, 1 % besides the standard error of its estimate where it is measured, and nothing is unknown of a
// simulated side whose noise was drawn from what is stated.
TEST(ExplainPhase, TheLimitFollowsFromHowWellTheNoiseIsKnown) {
  using measure::NoiseSource;
  struct Known {
    NoiseSource source;
    double standard_error, to;
  };
  const Known on_real[] = {{NoiseSource::known, 0.0, 0.05},
                           {NoiseSource::quantisation, 0.0, 0.05},
                           {NoiseSource::residuals, 0.0, 0.01},
                           {NoiseSource::residuals, 0.0075, 0.0125},  // 3, 4, 5
                           {NoiseSource::residuals, 0.024, 0.026}};   // 5, 12, 13
  Phases p = noisy_phases(kSigmaPx, 0.0);
  for (const Known& real : on_real)
    for (Known simulated : on_real) {
      if (simulated.source == NoiseSource::known) simulated.to = 0.0;  // drawn
      p.real.noise_source = real.source;
      p.real.noise_known_to = real.standard_error;
      p.simulated.noise_source = simulated.source;
      p.simulated.noise_known_to = simulated.standard_error;
      const ExplainedRow row = phase_of(p);
      // either side has half of the variance
      const double known_to = std::hypot(0.5 * real.to, 0.5 * simulated.to);
      EXPECT_NEAR(row.chi2_limit, 1.0 + allowed_above(static_cast<double>(row.n), known_to), 1e-9)
          << real.to << " " << simulated.to;
    }
}

// Fringes that lie elsewhere from place to place look like ripples: the limit grows by 1 % of what the
// regions have beyond noise, and by nothing of what they have below it.
TEST(ExplainPhase, ShiftsFromPlaceToPlaceMayRipple) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  p.real.noise_dn = p.simulated.noise_dn = 4.0;
  const RippleTest ripple{4.0, 0.5, 4, 4, 12, 1e8};
  const auto judged = [&](double regional_chi2) {
    ExplainedRow row = phase_of(p);
    EXPECT_GT(row.n_regions, 0u);
    row.regional_chi2_of_noise = regional_chi2;  // what is uncertain of a rig makes no ripples and takes none
    judge_ripple(ripple, {}, p.real, p.simulated, row);
    return row;
  };
  const double of_noise = 1.0 + 5.0 * std::sqrt(2.0 / 12.0);
  EXPECT_NEAR(judged(0.3).ripple_limit, of_noise, 1e-9);
  EXPECT_NEAR(judged(1.0).ripple_limit, of_noise, 1e-9);
  EXPECT_NEAR(judged(51.0).ripple_limit, of_noise + 0.5, 1e-9);
  EXPECT_THAT(judged(51.0).why, ::testing::HasSubstr("from image to image"));
  EXPECT_NEAR(judged(201.0).ripple_limit, of_noise + 2.0, 1e-9);
  EXPECT_EQ(judged(201.0).why, "");  // 4 is less than 5.04
}

}  // namespace
}  // namespace fringetwin::compare::explain_phase_test
