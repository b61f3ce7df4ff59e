// SPDX-License-Identifier: Apache-2.0
// Photon and read noise drawn on sinusoids -> estimate_noise() -> the line that was drawn from.
//
// | check                                  | tolerance | origin                                             |
// |----------------------------------------|-----------|----------------------------------------------------|
// | mean chi2, variance of the gray values | 0.02      | 4 standard errors, sqrt(4 / 150,000), N = 4        |
// | brightest tenth, factor of a pixel     | 0.03      | the slope is known to 0.7 %, N = 4                 |
// | darkest tenth                          | 0.05      | 4 standard errors, sqrt(4 / 25,000) unlit values   |
// | rms of the errors over known_to()      | 0.7 … 1.25 | 52 draws: 1 with 0.1; 0.9 where triples are apart |
// | mean chi2 of a small object            | 0.14      | 4 standard errors, sqrt(4 / 3300)                  |
#include "measure/decode/phase_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure::phase_noise_test {
namespace {

struct Rig {
  int steps = 4, bits = 8;
  double contrast = 0.45;      ///< amplitude over the light of full white
  double shading = 1.6;        ///< darkening towards the corners; 0: one level
  double outlier_share = 0.0;  ///< of the gray values
  bool noise = true;
  double unlit = 0.0;            ///< share of the pixels that hold nothing but the black level
  double second_harmonic = 0.0;  ///< over the amplitude, as a gamma makes it
  double texture = 0.0;          ///< of every second square of 6 px
  double tilt = 0.0;  ///< of the stripes, in periods of 13 px over a pixel along them, at the left edge

  double full_dn() const { return bits == 8 ? 210.0 : 3400.0; }
  double electrons_per_dn() const { return bits == 8 ? 40.0 : 2.5; }
  double read_dn() const { return bits == 8 ? 0.6 : 4.0; }
  double black_dn() const { return bits == 8 ? 8.0 : 100.0; }
  double variance(double dn) const {
    return (dn - black_dn()) / electrons_per_dn() + read_dn() * read_dn() + 1.0 / 12.0;
  }
};

/// Returns normal values, drawn once for all rigs.
class Normals {
 public:
  Normals() {
    std::mt19937_64 random(1);
    std::normal_distribution<float> normal;
    for (float& v : values_) v = normal(random);
  }
  double next() { return static_cast<double>(values_[at_++ % values_.size()]); }

 private:
  std::vector<float> values_ = std::vector<float>(1'999'993);
  std::size_t at_ = 0;
};
Normals& normals() {
  static Normals all;
  return all;
}

/// Drawn variances over estimated ones. Of sums over the gray values: as they are, and weighted as in a
/// factor per pixel, by the light's square. Means over single values: all, and the brightest and the darkest
/// tenth.
struct Ratios {
  double mean = 0.0, factor = 0.0, chi2 = 0.0, brightest = 0.0, darkest = 0.0, known_to = 0.0;
};

Ratios ratios_of(const NoiseModel& model, const Rig& rig, std::vector<float> light) {
  std::ranges::sort(light);
  double drawn = 0.0, estimated = 0.0, drawn_factor = 0.0, estimated_factor = 0.0;
  std::vector<double> ratio;
  for (float& value : light) {
    const auto dn = static_cast<double>(value);
    value += static_cast<float>(rig.black_dn());
    const double truth = rig.variance(rig.black_dn() + dn), found = model.variance(rig.black_dn() + dn);
    drawn += truth, estimated += found;
    drawn_factor += dn * dn * truth, estimated_factor += dn * dn * found;
    ratio.push_back(truth / found);
  }
  const auto tenth = static_cast<std::ptrdiff_t>(ratio.size() / 10);
  const auto mean = [](auto first, auto last) {
    return std::accumulate(first, last, 0.0) / static_cast<double>(last - first);
  };
  return {.mean = drawn / estimated,
          .factor = drawn_factor / estimated_factor,
          .chi2 = mean(ratio.begin(), ratio.end()),
          .brightest = mean(ratio.end() - tenth, ratio.end()),
          .darkest = mean(ratio.begin(), ratio.begin() + tenth),
          .known_to = model.known_to(light)};
}

Ratios ratios_of(const Rig& rig, const std::vector<int>& used = {}) {
  const int width = rig.steps == 4 ? 280 : 200, height = rig.steps == 4 ? 230 : 150;
  const std::vector<int> steps = used.empty() ? all_steps(rig.steps) : used;
  const StepSolver solver(steps, rig.steps);
  std::mt19937_64 random(static_cast<unsigned>(rig.steps));
  std::uniform_real_distribution<double> uniform;
  std::vector<std::vector<GrayImage>> images(3, std::vector<GrayImage>(steps.size(), ImageF(width, height)));
  ImageF amplitude(width, height, 1.0f);
  std::vector<ImageF> phases(3, amplitude);
  std::vector<float> light;
  std::vector<NoiseInput> pitches;
  for (std::size_t p = 0; p < images.size(); ++p) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double u = static_cast<double>(x) / width - 0.5, v = static_cast<double>(y) / height - 0.5;
        const bool lit = u < 0.5 - rig.unlit;
        const double coordinate_px =
            40.0 + 0.83 * x + 0.11 * y + 2e-4 * x * y + rig.tilt * 13.0 * y * (0.5 - u);
        const double angle = kTwoPi * coordinate_px / (13.0 + static_cast<double>(p));
        double white = lit ? rig.full_dn() * (1.0 - rig.shading * (u * u + v * v)) : 0.0;
        if ((x / 6 + y / 6) % 2 == 1) white *= 1.0 - rig.texture;
        amplitude(x, y) = static_cast<float>(white * rig.contrast);
        phases[p](x, y) = lit ? static_cast<float>(angle) : std::numeric_limits<float>::quiet_NaN();
        for (std::size_t k = 0; k < steps.size(); ++k) {
          const double turn = kTwoPi * steps[k] / rig.steps;
          const double dn =
              white * (0.5 + rig.contrast * (std::cos(angle + turn) +
                                             rig.second_harmonic * std::cos(2.0 * (angle + turn))));
          if (lit && y % 4 == 0) light.push_back(static_cast<float>(dn));
          double drawn = rig.black_dn() + dn;
          if (rig.noise) drawn += std::sqrt(rig.variance(drawn) - 1.0 / 12.0) * normals().next();
          if (rig.outlier_share > 0.0 && uniform(random) < rig.outlier_share) drawn += 0.3 * rig.full_dn();
          images[p][k].writable(x, y) = static_cast<float>(std::round(drawn));
        }
      }
    pitches.push_back({{}, &phases[p], &amplitude});
    for (const GrayImage& image : images[p]) pitches.back().steps.push_back(&image);
  }
  const auto model = estimate_noise(pitches, solver, Axis::x,
                                    {.saturation = rig.bits == 8 ? 255.0 : 4095.0, .least = 1.0 / 12.0});
  return model ? ratios_of(*model, rig, std::move(light)) : Ratios{};
}

TEST(PhaseNoise, IsWhatWasDrawnForAnyNumberOfSteps) {
  double squares = 0.0, n = 0.0;
  for (const int bits : {8, 12})
    for (const double contrast : {0.45, 0.5})
      for (int steps = 4; steps <= 16; ++steps) {
        const Ratios r = ratios_of({.steps = steps, .bits = bits, .contrast = contrast, .unlit = 0.2});
        const ::testing::ScopedTrace trace(
            __FILE__, __LINE__, ::testing::Message() << steps << " steps, " << bits << " bit, " << contrast);
        EXPECT_NEAR(r.chi2, 1.0, 0.02);
        EXPECT_NEAR(r.mean, 1.0, 0.02);
        EXPECT_NEAR(r.factor, 1.0, 0.03);
        EXPECT_NEAR(r.brightest, 1.0, 0.03);
        EXPECT_NEAR(r.darkest, 1.0, 0.05);
        EXPECT_LT(r.known_to, 0.007);
        squares += std::pow((r.chi2 - 1.0) / r.known_to, 2), n += 1.0;
      }
  EXPECT_GT(std::sqrt(squares / n), 0.7);
  EXPECT_LT(std::sqrt(squares / n), 1.25);
}

TEST(PhaseNoise, WithoutUnlitPixelsKnowsItsOwnError) {
  // the valleys reach the black level, and the one contrast of four steps sees the mean level alone
  const Ratios r = ratios_of({.steps = 4, .bits = 12, .contrast = 0.5});
  EXPECT_GT(r.known_to, 0.01);
  EXPECT_LT(std::abs(r.chi2 - 1.0), 4.0 * r.known_to);
  EXPECT_NEAR(r.mean, 1.0, 0.02);
}

TEST(PhaseNoise, UnlitPixelsThatClipOrRoundAreLeftOut) {
  const std::vector<NoiseValue> lit(300, {100.0f, 1.0f});
  const auto used = [&](float level, float noise) {
    std::vector<NoiseValue> values = lit;
    add_unlit(std::vector<NoiseValue>(300, {level, noise}), 3, {.saturation = 255.0, .least = 1.0 / 12.0},
              values);
    return values.size() > lit.size();
  };
  EXPECT_TRUE(used(8.0f, 0.5f));     // 0.74 DN
  EXPECT_FALSE(used(2.0f, 0.5f));    // 3.5 sigmas reach 0
  EXPECT_FALSE(used(253.0f, 0.5f));  // or the full scale
  EXPECT_FALSE(used(8.0f, 0.3f));    // 0.44 DN: most noise rounds away
}

TEST(PhaseNoise, ASmallObjectInALargeImageTellsItsNoise) {
  const Rig rig;
  const int width = 2048, height = 1536;
  std::vector<GrayImage> images(4, ImageF(width, height));
  const ImageF ones(width, height, 1.0f);
  ImageF phase(width, height, std::numeric_limits<float>::quiet_NaN());
  for (int y = 700; y < 765; ++y)
    for (int x = 1000; x < 1065; ++x) {
      if (std::hypot(x - 1032, y - 732) > 32.5) continue;
      phase(x, y) = 0.0f;
      for (std::size_t k = 0; k < 4; ++k) {
        const double dn = rig.black_dn() +
                          100.0 * (1.0 + 0.9 * std::cos(kTwoPi * (x / 13.0 + 0.25 * static_cast<double>(k))));
        images[k].writable(x, y) =
            static_cast<float>(std::round(dn + std::sqrt(rig.variance(dn) - 1.0 / 12.0) * normals().next()));
      }
    }
  NoiseInput input{{}, &phase, &ones};
  for (const GrayImage& image : images) input.steps.push_back(&image);
  const auto model = estimate_noise({input}, StepSolver(all_steps(4), 4), Axis::x,
                                    {.saturation = 255.0, .least = 1.0 / 12.0});
  ASSERT_TRUE(model);
  EXPECT_LT(model->known_to({108.0f}), 0.05);  // 0.11 of every third pixel
  EXPECT_NEAR(model->variance(108.0) / rig.variance(108.0), 1.0, 0.14);
}

TEST(PhaseNoise, FactorsOfMedianAndCutAreThoseOfNormalValues) {
  // four steps have one contrast: the median of its square over the variance is that of chi2(1), 0.4549
  EXPECT_NEAR(std::erf(1.0 / kMadToSigma / std::numbers::sqrt2), 0.5, 1e-4);
  const double density = std::exp(-0.5 * kCutSigmas * kCutSigmas) / std::sqrt(kTwoPi);
  EXPECT_NEAR(kKeptVariance, 1.0 - 2.0 * kCutSigmas * density / std::erf(kCutSigmas / std::numbers::sqrt2),
              1e-5);
}

TEST(PhaseNoise, FringesAloneTellHowNoiseGrowsWithTheLevel) {
  // one mean level: with N > 4 the contrasts differ in theirs all the same
  for (const int steps : {5, 6, 9, 16})
    EXPECT_NEAR(ratios_of({.steps = steps, .bits = 12, .shading = 0.0}).factor, 1.0, 0.03) << steps;
  // with N = 4 they do not: the mean is right, and no slope is made up from nothing
  const Ratios four = ratios_of({.steps = 4, .bits = 12, .shading = 0.0});
  EXPECT_NEAR(four.mean, 1.0, 0.02);
  EXPECT_GT(four.factor, 0.9);
  EXPECT_LT(four.factor, 1.7);  // 1.65: shot noise taken at the mean level
}

TEST(PhaseNoise, SomeOfTheStepsTellTheSame) {
  const Ratios r = ratios_of({.steps = 12, .bits = 12}, {0, 1, 3, 4, 6, 7, 9, 11});
  EXPECT_NEAR(r.mean, 1.0, 0.02);
  EXPECT_NEAR(r.factor, 1.0, 0.03);
}

TEST(PhaseNoise, HarmonicsOfBentStripesAreNoNoise) {
  // stripes that turn by up to 0.06 of a period per pixel: without care the variance is 1.3 times too
  // large
  for (const int steps : {4, 5, 6}) {
    const Ratios r =
        ratios_of({.steps = steps, .bits = 12, .unlit = 0.2, .second_harmonic = 0.08, .tilt = 0.06});
    EXPECT_NEAR(r.mean, 1.0, 0.02) << steps;
    EXPECT_NEAR(r.chi2, 1.0, 0.02) << steps;
  }
}

TEST(PhaseNoise, HarmonicsOnTextureAreNoNoise) {
  // a checker: without care the variance is 1.4 to 2 times too large
  for (const int steps : {4, 6, 8}) {
    const Ratios r =
        ratios_of({.steps = steps, .bits = 12, .unlit = 0.2, .second_harmonic = 0.08, .texture = 0.6});
    EXPECT_NEAR(r.mean, 1.0, 0.03) << steps;
    EXPECT_NEAR(r.chi2, 1.0, 0.03) << steps;
  }
}

TEST(PhaseNoise, HarmonicsMoveNoLevel) {
  // a gamma of 2: at the sinusoid's own level the darkest tenth has up to 1.25 times the variance drawn
  for (const int bits : {8, 12})
    for (const int steps : {6, 7, 8, 12}) {
      const Ratios r = ratios_of({.steps = steps, .bits = bits, .second_harmonic = 0.25});
      EXPECT_NEAR(r.chi2, 1.0, 0.02) << steps;
      EXPECT_NEAR(r.brightest, 1.0, 0.03) << steps;
      EXPECT_NEAR(r.darkest, 1.0, 0.05) << steps;
    }
}

TEST(PhaseNoise, OutliersAreNoNoise) {
  for (const int steps : {4, 8})
    for (const int bits : {8, 12})
      EXPECT_NEAR(ratios_of({.steps = steps, .bits = bits, .outlier_share = 0.01, .unlit = 0.2}).mean, 1.0,
                  0.02);
}

TEST(PhaseNoise, AFewOutliersMoveNoLine) {
  // one value in 10,000, valleys at the black level and no unlit pixels: with the lowest of all fitted
  // valleys as the darkest step the dark tenth has 0.55 of the variance drawn over that estimated
  for (const int steps : {6, 8})
    EXPECT_GT(ratios_of({.steps = steps, .bits = 12, .contrast = 0.5, .outlier_share = 1e-4}).darkest, 0.7)
        << steps;
}

TEST(PhaseNoise, NothingIsQuieterThanRounding) {
  Rig rig;
  rig.noise = false;
  const Ratios r = ratios_of(rig);  // what was drawn over 1/12
  EXPECT_GT(r.mean, 1.0);
  std::vector<NoiseValue> silent(1000, {100.0f, 0.0f});
  const auto model = fit_noise(silent, 1, 0.0, 1.0 / 12.0);
  ASSERT_TRUE(model);
  for (const double dn : {0.0, 100.0, 255.0}) EXPECT_DOUBLE_EQ(model->variance(dn), 1.0 / 12.0);
  EXPECT_DOUBLE_EQ(fit_noise(silent, 1, 0.0, 0.0)->variance(0.5), 0.0);  // irradiance without noise
  EXPECT_DOUBLE_EQ(fit_noise(silent, 1, 0.0, 0.0)->known_to({100.0f}), 0.0);
}

TEST(PhaseNoise, TooFewValuesTellNothing) {
  std::vector<NoiseValue> values(199, {100.0f, 1.0f});
  EXPECT_FALSE(fit_noise(values, 1, 0.0, 0.0));
  values.push_back({100.0f, -1.0f});
  EXPECT_TRUE(fit_noise(values, 1, 0.0, 0.0));
}

TEST(PhaseNoise, RoughTriplesAreLeftOut) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::vector<NoiseValue> values;
  for (int i = 0; i < 20'000; ++i) {
    const bool rough = i % 4 == 0;
    values.push_back({static_cast<float>(50 + i % 100),
                      static_cast<float>((rough ? 3.0 : 2.0) * normal(random)), rough ? 50.0f : 1.0f});
  }
  EXPECT_NEAR(fit_noise(values, 1, 0.0, 1.0 / 12.0)->variance(100.0), 4.0, 0.2);  // 4 sqrt(2/15,000) 4
}

}  // namespace
}  // namespace fringetwin::measure::phase_noise_test
