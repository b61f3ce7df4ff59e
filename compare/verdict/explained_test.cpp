// SPDX-License-Identifier: Apache-2.0
// Verdicts of the budget on made images: noise as stated is explained, more is not.
//
// | check                             | tolerance | origin                                           |
// |-----------------------------------|-----------|--------------------------------------------------|
// | chi2 of noise as stated           | 0.05      | 5 times what the noise is known to, 1 % (N = 4…8) |
// | chi2 of noise of 1.3 the variance | 0.02      | scatter of a variance over 2e5 values is 0.003   |
// | regional chi2 of noise            | 0.15      | 3 sqrt(2/n), n > 800 blocks                      |
// | of scatter not in the budget      | 0.5       | the same, times 3.17                             |
// | chi2 of a quarter of the variance | 0.005     | scatter of a variance over 1e5 values is 0.0045  |
// | factor of that, gray              | 0.02      | half of that, times 2                            |
// | chi2 of phase, a quarter on one   | 0.02      | 4 standard errors, sqrt(2/n) 0.625, n = 40,000   |
#include "compare/verdict/explained.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "compare/gray/interior_mask.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::explained_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

SidesTruth one_pitch(SidesTruth t) {
  t.width = 256;
  t.height = 240;
  t.pitches_px = {13};
  t.steps = 8;
  return t;
}
SidesTruth deep() { return one_pitch(testing::deep_truth(60.0)); }

ExplainedRow gray_of(SyntheticSides scene, const RenderingError& rendering = {}) {
  const testing::FittedGray gray(std::move(scene));
  const measure::CameraDecode *real = gray.real_decode(), *simulated = gray.simulated_decode();
  return explain_gray(gray.pair, gray.fit, gray.noise(), interior_mask(gray.pair.mask, real, simulated),
                      simulated, rendering, nullptr, seen_pixels(real, simulated));
}

TEST(Explained, NoiseAsItIsMeasuredIsExplained) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SidesTruth t = deep();
    t.seed = seed;
    const ExplainedRow row = gray_of(testing::make_sides(t));
    EXPECT_TRUE(row.explained());
    EXPECT_NEAR(row.chi2, 1.0, 0.05);
    EXPECT_NEAR(row.regional_chi2, 1.0, 0.15);
    EXPECT_GT(row.n_regions, 300u);
    EXPECT_NEAR(row.expected() / (t.noise_dn * t.noise_dn + 1.0 / 12.0), 1.0, 0.05);
    EXPECT_EQ(row.region, "left");
    EXPECT_EQ(row.state, "explained");
    EXPECT_EQ(row.why, "");
    EXPECT_GT(row.compared_fraction, 0.9);
    EXPECT_NEAR(row.noise_chi2, row.chi2, 1e-9);  // nothing else is in this budget
    // 1 - 3 sqrt(2/n + 0.01^2 + u^2), n = 3e5; 2e5 values leave the noise unknown to u = 0.004 or a little
    // more
    EXPECT_NEAR(row.chi2_least, 0.967, 0.004);
  }
}

TEST(Explained, NoiseBelowTheRoundingIsExplained) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SidesTruth t = one_pitch({});
    t.black_level_dn = 20.0;
    t.gain_dn = 14.0;
    t.noise_dn = 0.3;
    t.seed = seed;
    const ExplainedRow row = gray_of(testing::make_sides(t));
    EXPECT_TRUE(row.explained()) << row.chi2 << ' ' << row.regional_chi2;
    ASSERT_EQ(row.lines.size(), 4u);
    EXPECT_NEAR(row.lines[1].variance, 1.0 / 12.0, 1e-9);
  }
}

/// Three steps of one pitch tell no noise apart from texture: the twin's sensor model stands.
SyntheticSides modelled(const SidesTruth& t, double stated_dn2) {
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = std::sqrt(stated_dn2);
  return scene;
}

TEST(Explained, MoreNoiseThanTheSensorModelStatesIsNot) {
  SidesTruth t = deep();
  t.steps = 3;
  const double total_dn2 = t.noise_dn * t.noise_dn + 1.0 / 12.0;
  const ExplainedRow as_stated = gray_of(modelled(t, t.noise_dn * t.noise_dn));
  EXPECT_TRUE(as_stated.explained());
  EXPECT_NEAR(as_stated.chi2, 1.0, 0.02);
  EXPECT_THAT(as_stated.lines.at(0).name, ::testing::HasSubstr("sensor model"));
  const ExplainedRow less_stated = gray_of(modelled(t, total_dn2 / 1.3 - 1.0 / 12.0));
  EXPECT_FALSE(less_stated.explained());
  EXPECT_NEAR(less_stated.chi2, 1.3, 0.02);
}

TEST(Explained, LessNoiseThanTheSensorModelStatesMakesTheBudgetTooWide) {
  SidesTruth t = deep();
  t.steps = 3;
  const double total_dn2 = t.noise_dn * t.noise_dn + 1.0 / 12.0;
  const ExplainedRow row = gray_of(modelled(t, 4.0 * total_dn2 - 1.0 / 12.0));
  EXPECT_NEAR(row.noise_chi2, 0.25, 0.005);
  EXPECT_EQ(row.state, "budget too wide");
  EXPECT_FALSE(row.explained());
  EXPECT_NEAR(row.too_wide_factor, 2.0, 0.02);
  EXPECT_THAT(row.why, ::testing::HasSubstr("0.50 of what the noise in the budget says"));
  EXPECT_TRUE(row.states_noise);
}

TEST(Explained, ARenderingErrorDoesNotMakeTheNoiseTooWide) {
  SidesTruth t = deep();
  t.steps = 3;
  const ExplainedRow row = gray_of(modelled(t, t.noise_dn * t.noise_dn),
                                   {.gray_dn = 3.0 * t.noise_dn, .phase_rad = 0.0, .estimated = true});
  EXPECT_LT(row.chi2, 0.2);
  EXPECT_EQ(row.state, "explained");
}

TEST(Explained, SidesThatRoundAlikeAreNotTooWide) {
  SidesTruth t = deep();
  t.noise_dn = 0.0;
  SyntheticSides scene = testing::make_sides(t);
  scene.simulated.images = scene.real.images;  // the very same gray values
  scene.simulated.irradiance.clear();
  const ExplainedRow row = gray_of(scene);
  EXPECT_LT(row.chi2, 1e-6);
  EXPECT_EQ(row.state, "explained");
  EXPECT_TRUE(std::isnan(row.chi2_least));
}

/// Three steps at three pitches; the twin states `factor` times the noise.
SyntheticSides three_pitches(double factor) {
  SidesTruth t = deep();
  t.steps = 3;
  t.pitches_px = {13, 14, 15};
  return modelled(t, factor * factor * (t.noise_dn * t.noise_dn + 1.0 / 12.0) - 1.0 / 12.0);
}

TEST(Explained, ThreeStepsAtSeveralPitchesTellTheirNoise) {
  for (const double factor : {0.5, 1.0, 6.0}) {  // whatever the twin says
    const ExplainedRow row = gray_of(three_pitches(factor));
    EXPECT_EQ(row.state, "explained") << row.chi2;
    EXPECT_NEAR(row.chi2, 1.0, 0.05);
    EXPECT_FALSE(row.states_noise);
    EXPECT_THAT(row.lines.at(0).name, ::testing::HasSubstr("the pitches' means"));
  }
}

TEST(Explained, LessThanHalfOfThePixelsIsNotCompared) {
  SyntheticSides scene = testing::make_sides(deep());
  ImageU8& flags = scene.real.measurement->cameras[0].flags;
  const auto lose = [&](double fraction) {
    for (int y = 0; y < static_cast<int>(fraction * flags.height); ++y)
      for (int x = 0; x < flags.width; ++x)
        if (flags(x, y) == measure::kValid) flags(x, y) = measure::kSaturated;
    return gray_of(scene);
  };
  EXPECT_EQ(lose(0.4).state, "explained");
  const ExplainedRow row = lose(0.6);
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_FALSE(row.explained());
  EXPECT_NEAR(row.compared_fraction, 0.37, 0.03);  // of a disc: 0.5 - (asin h + h sqrt(1-h^2))/pi, h = 0.22
  EXPECT_THAT(row.why, ::testing::HasSubstr("% of the pixels that a side sees"));
}

TEST(Explained, MostGrayValuesAtTheEndsOfTheScaleAreNotCompared) {
  SidesTruth t = deep();
  t.steps = 3;
  t.weight = 60.0;  // 12,000 DN of 4095: most steps saturate
  const ExplainedRow row = gray_of(modelled(t, t.noise_dn * t.noise_dn));
  EXPECT_LT(row.compared_fraction, 0.5);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_THAT(row.why, ::testing::HasSubstr("% of the gray values"));
}

TEST(Explained, WhatIsCommonToARegionIsNot) {
  // 0.1 % of shading over half the image: 2 % of the noise's square, but in every step and pixel alike
  SyntheticSides scene = testing::make_sides(deep());
  for (ImageF& image : scene.simulated.irradiance[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = image.width / 2; x < image.width; ++x) image(x, y) *= 1.001F;
  const ExplainedRow row = gray_of(scene);
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_GT(row.regional_chi2, 1.5 * row.regional_limit);
  EXPECT_FALSE(row.explained());
}

TEST(Explained, TheRenderersOwnErrorIsPartOfTheBudget) {
  SidesTruth t = deep();
  t.steps = 3;
  const double missing_dn2 = 0.3 * t.noise_dn * t.noise_dn;
  const SyntheticSides scene = modelled(t, t.noise_dn * t.noise_dn - missing_dn2);
  EXPECT_FALSE(gray_of(scene).explained());
  const ExplainedRow row =
      gray_of(scene, {.gray_dn = std::sqrt(missing_dn2), .phase_rad = 0.0, .estimated = true});
  EXPECT_TRUE(row.explained());
  EXPECT_NEAR(row.lines.at(2).variance, missing_dn2, 1e-9);
}

/// Errors of every pixel's own, alike in its images or turning with the fringe: common + a cos d + b sin d,
/// all normal; a and b of the same sigma. Directions of bounces leave such errors.
struct Scatter {
  double common_dn, turning_dn;
  Eigen::MatrixXd covariance(const std::vector<double>& steps_rad) const {
    const auto n = static_cast<Eigen::Index>(steps_rad.size());
    return Eigen::MatrixXd::NullaryExpr(n, n, [&](Eigen::Index k, Eigen::Index l) {
      return common_dn * common_dn + turning_dn * turning_dn * std::cos(steps_rad[k] - steps_rad[l]);
    });
  }
};

TEST(Explained, WhatIsOffInAPixelAsAWholeAddsUpOverItsImagesNotOverPixels) {
  const SidesTruth t = deep();
  const Scatter scatter{2.0, 3.0};
  SyntheticSides scene = testing::make_sides(t);
  std::vector<double> steps_rad;
  for (int k = 0; k < t.steps; ++k) steps_rad.push_back(2.0 * std::numbers::pi * k / t.steps);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < scene.real.images[0].images[0].size(); ++i) {
    const double common = scatter.common_dn * normal(random), a = scatter.turning_dn * normal(random),
                 b = scatter.turning_dn * normal(random);
    for (int k = 0; k < t.steps; ++k)
      scene.real.images[0].images[k].data[i] +=
          static_cast<float>(std::round(common + a * std::cos(steps_rad[k]) + b * std::sin(steps_rad[k])));
  }
  // a pixel's 8 values add up to a variance of 8 v + 64 c^2, by cos(d + phase) to 4 v + 16 r^2; v = 4^2 + 1/6
  const double v = t.noise_dn * t.noise_dn + 1.0 / 6.0, level = 8.0 * 4.0 / v, fringe = 4.0 * 9.0 / v;
  const ExplainedRow unstated = gray_of(scene);
  EXPECT_NEAR(unstated.regional_chi2, 1.0 + (level + 2.0 * fringe) / 3.0, 0.5);
  const RenderingError stated{.estimated = true, .scatter_dn2 = scatter.covariance(steps_rad)};
  const ExplainedRow row = gray_of(scene, stated);
  EXPECT_NEAR(row.chi2, 1.0, 0.05);
  EXPECT_NEAR(row.regional_chi2, 1.0, 0.15);
  EXPECT_EQ(row.state, "explained") << row.why;
  EXPECT_NEAR(row.lines.at(2).variance, 4.0 + 9.0, 1e-9);
  // what all pixels have in common shows through it
  for (ImageF& image : scene.simulated.irradiance[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = image.width / 2; x < image.width; ++x) image(x, y) *= 1.002F;
  EXPECT_GT(gray_of(scene, stated).regional_chi2, 1.5 * row.regional_limit);
}

TEST(Explained, RenderingErrorIsReadFromTheNoteOfItsCamera) {
  const SyntheticSides scene = testing::make_sides(deep());
  RenderNote other, own;
  other.camera = "right";
  other.gray_error = 1.0;
  own.camera = "left";
  own.gray_error = 1e-3;
  own.phase_error_rad = 2e-4;
  const RenderingError error =
      rendering_error(scene.twin.cameras[0], {other, own}, scene.twin.cameras[0].sensor.gain_dn);
  EXPECT_TRUE(error.estimated);
  EXPECT_NEAR(error.gray_dn, 4.095, 1e-9);
  EXPECT_EQ(error.phase_rad, 2e-4);
  own.gray_inside_error = 1e-5;  // interior pixels are judged: the edges' error is not theirs
  EXPECT_NEAR(
      rendering_error(scene.twin.cameras[0], {other, own}, scene.twin.cameras[0].sensor.gain_dn).gray_dn,
      0.04095, 1e-9);
  EXPECT_FALSE(rendering_error(scene.twin.cameras[0], {other}, 1.0).estimated);
}

/// Decodes of the same surface, with Gaussian noise of a stated sigma on both sides and an offset.
struct Phases {
  measure::DirectionDecode real, simulated;
  ImageU8 interior;
};

Phases noisy_phases(double sigma_px, double offset_px, double noise_factor = 1.0) {
  SidesTruth t = deep();
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
  return explain_phase("left", p.real, p.simulated, p.interior, rendering);
}

constexpr double kSigmaPx = 0.01;
/// Of the difference's mean over a whole block of 16 x 16 px.
const double kRegionalSigmaPx = kSigmaPx * std::numbers::sqrt2 / 16.0;

TEST(Explained, PhaseNoiseAsStatedIsExplained) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 0.0));
  EXPECT_TRUE(row.explained());
  EXPECT_NEAR(row.chi2, 1.0, 0.05);
  EXPECT_NEAR(row.regional_chi2, 1.0, 3.0 * std::sqrt(2.0 / static_cast<double>(row.n_regions)));
  const double per_px = 2.0 * std::numbers::pi / 13.0;
  EXPECT_NEAR(row.expected() / (2.0 * std::pow(kSigmaPx * per_px, 2)), 1.0, 1e-3);
  EXPECT_EQ(row.region, "left x");
}

TEST(Explained, AConstantPhaseOffsetOfThreeRegionalSigmasIsNot) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 3.0 * kRegionalSigmaPx));
  EXPECT_LE(row.chi2, row.chi2_limit);        // no single pixel tells
  EXPECT_NEAR(row.regional_chi2, 10.0, 3.0);  // 1 + 9, less where a block is cut off by the disc
  EXPECT_FALSE(row.explained());
}

TEST(Explained, TooMuchPhaseNoiseIsNot) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 0.0, std::sqrt(1.3)));
  EXPECT_NEAR(row.chi2, 1.3, 0.05);
  EXPECT_FALSE(row.explained());
}

TEST(Explained, APhaseErrorOfTheRendererIsPartOfTheBudget) {
  const double per_px = 2.0 * std::numbers::pi / 13.0;
  RenderingError rendering;
  rendering.phase_rad = 3.0 * kRegionalSigmaPx * per_px;
  EXPECT_TRUE(phase_of(noisy_phases(kSigmaPx, 3.0 * kRegionalSigmaPx), rendering).explained());
}

TEST(Explained, TextureWithinAPixelMovesItsPhase) {
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

TEST(Explained, TooFewValuesAreNotCompared) {
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

TEST(Explained, OrdersThatDisagreeOnMostPixelsAreNotCompared) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  std::uint64_t lit = 0;
  for (const double x : p.real.coordinate_px.data) lit += std::isnan(x) ? 0 : 1;
  const SeenPixels seen{.both = lit, .either = lit};
  const auto row_with = [&](int from_column) {  // a period off to the right of it
    Phases q = p;
    for (int y = 0; y < q.real.coordinate_px.height; ++y)
      for (int x = from_column; x < q.real.coordinate_px.width; ++x) q.real.coordinate_px(x, y) += 13.0;
    return explain_phase("left", q.real, q.simulated, q.interior, {}, nullptr, seen);
  };
  EXPECT_EQ(row_with(140).state, "explained");
  const ExplainedRow row = row_with(116);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_LT(row.compared_fraction, 0.5);
}

TEST(Explained, TooLittlePhaseNoiseMakesTheBudgetTooWide) {
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

TEST(Explained, ARippleBeyondNoiseIsNot) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  p.real.noise_dn = p.simulated.noise_dn = 4.0;
  const RippleTest noise{1.5, 0.5, 4, 12, 1e8}, flicker{3.2, 0.5, 4, 12, 1e8},
      waveform{1.5, 21.0, 4, 12, 1e8};
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

FitRow fit_row(double z_radius, double z_center_y) {
  FitRow row;
  row.object = "ball";
  row.kind = "sphere";
  measure::ObjectFit real;
  real.usable = true;
  real.numbers = {{"radius_sigma_mm", 0.003}};
  real.vectors = {{"center_sigma_mm", {0.001, 0.003, 0.001}}};
  row.real = real;
  real.numbers["radius_sigma_mm"] = 0.004;
  real.vectors["center_sigma_mm"].y() = 0.004;
  row.simulated = real;
  row.z = {{"radius_mm", z_radius}};
  row.difference = {{"radius_mm", 0.005 * z_radius}};
  row.z_vectors = {{"center_mm", {0.1, z_center_y, kNaN}}};
  row.difference_vectors = {{"center_mm", {0.0001, 0.005 * z_center_y, 0.7}}};
  return row;
}

// The limit is 3.21 standard errors of a single number, 3.60 of the largest of three
// (docs/metrics/verdict.md).
TEST(Explained, GeometryWithinItsStandardErrorsIs) {
  EXPECT_NEAR(most_sigmas_of(1), 3.21, 0.005);
  const auto rows = explain_geometry({fit_row(1.0, -3.5), fit_row(3.7, 0.5)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_TRUE(rows[0].explained());
  EXPECT_EQ(rows[0].worst, "center_mm.y");
  EXPECT_NEAR(rows[0].chi2, 3.5 * 3.5, 1e-12);
  EXPECT_NEAR(std::sqrt(rows[0].chi2_limit), 3.60, 0.005);
  EXPECT_NEAR(rows[0].observed, std::pow(0.005 * 3.5, 2), 1e-12);
  EXPECT_NEAR(rows[0].expected(), 25e-6, 1e-12);  // 3² + 4² µm²
  EXPECT_EQ(rows[0].n, 3u);                       // the unknown z is not counted
  EXPECT_FALSE(rows[1].explained());
  EXPECT_EQ(rows[1].worst, "radius_mm");
  EXPECT_EQ(rows[1].unit, "mm");
  EXPECT_EQ(worst_state(rows, "geometry"), "not explained");
  EXPECT_EQ(worst_state({rows[0]}, "geometry"), "explained");
  EXPECT_EQ(worst_state(rows, "gray"), "");
}

TEST(Explained, GeometryWithoutStandardErrorsIsNotCompared) {
  FitRow row = fit_row(1.0, 1.0);
  row.z.clear();
  row.z_vectors.clear();
  const auto rows = explain_geometry({row});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].state, "not compared");
  EXPECT_EQ(rows[0].region, "ball");
  EXPECT_THAT(rows[0].why, ::testing::HasSubstr("no standard error"));
}

TEST(Explained, GeometryThatOneSideLacksIsNotCompared) {
  FitRow row = fit_row(1.0, 1.0);
  row.real->usable = false;
  row.real->n = 12;
  row.real->warning = "only 12 points";
  EXPECT_EQ(explain_geometry({row}).at(0).why, "real fit on 12 points: only 12 points");
  row.simulated.reset();
  EXPECT_EQ(explain_geometry({row}).at(0).why, "the simulated side has no fit");
  row.real.reset();  // nothing was measured: nothing to compare
  EXPECT_TRUE(explain_geometry({row}).empty());
}

}  // namespace
}  // namespace fringetwin::compare::explained_test
