// SPDX-License-Identifier: Apache-2.0
// Factors of the images' light, planted into fringes that are made by plain numbers.
//
// | check                   | tolerance | origin                                                            |
// |-------------------------|-----------|-------------------------------------------------------------------|
// | planted factors         | 4 sigma   | 400 numbers, normal: one seed in 40 has one beyond                |
// | sigma over 200 draws    | 6 %       | 1200 z and more: 2 %, three times that                            |
// | light's phase           | 1 %       | second order of factors of 1 %                                    |
// | factors taken out       | 2e-6      | gray values of 200 in single precision, twice                     |
#include "measure/light/light_factors.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

namespace fringetwin::measure::light_factors_test {
namespace {

constexpr double kPi = std::numbers::pi;

Fringes fringes_of(int steps, std::vector<double> pitches_px) {
  const std::vector<double> origin(pitches_px.size(), 0.0);
  return {.directions = {{Axis::x, std::move(pitches_px), origin, {}}},
          .steps = steps,
          .unwrap = Unwrap::none,
          .images = {}};
}

/// What a made-up camera sees: a rough surface, brighter in the middle, on a dark ground.
struct Scene {
  int width = 96, height = 80;
  double gamma = 1.0, noise_dn = 0.6, black_dn = 6.0, full_dn = 255.0;
  double electrons_per_dn = 0.0;  ///< 0: no shot noise
  bool has_glare = false;         ///< a spot that saturates
  double phase_per_px = 1.0;      ///< 0: all pixels have the same phase
};

/// Returns the images, image k times factor[k] above black, rounded.
CameraImages record(const Scene& s, const Fringes& fringes, const std::vector<double>& factor,
                    unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::mt19937 of_surface(7);
  std::uniform_real_distribution<double> roughness(0.7, 1.0);
  std::vector<double> albedo;
  for (int y = 0; y < s.height; ++y)
    for (int x = 0; x < s.width; ++x) {
      const double u = (x - 0.5 * s.width) / s.width, v = (y - 0.5 * s.height) / s.height;
      const double glare = s.has_glare && std::hypot(u - 0.2, v) < 0.05 ? 2.0 : 1.0;
      albedo.push_back(std::abs(u) > 0.45 ? 0.01 : glare * (1.0 - u * u - v * v) * roughness(of_surface));
    }
  CameraImages out;
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    const double pitch = fringes.directions[0].pitches_px[static_cast<std::size_t>(sequence[k].pitch)],
                 delta = 2.0 * kPi * sequence[k].step / fringes.steps;
    ImageF image(s.width, s.height);
    for (int y = 0; y < s.height; ++y)
      for (int x = 0; x < s.width; ++x) {
        const double at_px = s.phase_per_px * (2.1 * x + 0.31 * y),
                     shown = std::pow(0.5 + 0.45 * std::cos(2.0 * kPi * at_px / pitch + delta), s.gamma),
                     light_dn = factor[k] * 230.0 * albedo[image.index(x, y)] * shown,
                     shot = s.electrons_per_dn > 0.0 ? light_dn / s.electrons_per_dn : 0.0,
                     dn = s.black_dn + light_dn + std::sqrt(s.noise_dn * s.noise_dn + shot) * noise(random);
        image(x, y) = static_cast<float>(std::round(std::clamp(dn, 0.0, s.full_dn)));
      }
    out.images.push_back(std::move(image));
  }
  return out;
}

LightOptions of(const Scene& s) {
  const double per_dn = s.electrons_per_dn > 0.0 ? 1.0 / s.electrons_per_dn : 0.0;
  return {.black_level_dn = s.black_dn,
          .min_amplitude = 5.0,
          .variance_offset_dn2 = s.noise_dn * s.noise_dn + 1.0 / 12.0 - per_dn * s.black_dn,
          .variance_per_dn = per_dn};
}

/// Returns factors of so many images, 2 % to either side, of geometric mean 1.
std::vector<double> flicker(std::size_t n, unsigned seed, double share = 0.02) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-share, share);
  std::vector<double> out;
  double mean = 0.0;
  for (std::size_t k = 0; k < n; ++k) out.push_back(any(random)), mean += out.back() / static_cast<double>(n);
  for (double& f : out) f = std::exp(f - mean);
  return out;
}

void expect_found(const LightFactors& found, const std::vector<double>& truth, double most_sigma) {
  ASSERT_EQ(found.factor.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(std::log(found.factor[k] / truth[k]), 0.0, 4.0 * found.sigma[k]) << "image " << k;
    EXPECT_LT(found.sigma[k], most_sigma);
    EXPECT_GT(found.sigma[k], 0.0);
  }
}

// Some of the steps, unevenly spaced, tell theirs, and no other image is looked at. Every second of twelve
// takes a fifth harmonic for a pixel's own fringe, which is no factor then.
TEST(LightFactors, AreFoundOfSomeSteps) {
  const Fringes fringes = fringes_of(12, {13.0, 17.0});
  const std::vector<double> truth = flicker(24, 5);
  const Scene scene{.gamma = 1.6, .has_glare = true};
  CameraImages images = record(scene, fringes, truth, 3);
  for (const std::vector<int>& steps :
       {std::vector<int>{1, 2, 4, 5, 7, 8, 10, 11}, std::vector<int>{0, 1, 3, 4, 6, 7, 9, 10},
        std::vector<int>{0, 1, 3, 7, 8}, std::vector<int>{0, 2, 4, 6, 8, 10}}) {
    SCOPED_TRACE(::testing::PrintToString(steps));
    const auto found = estimate_light(images, fringes, of(scene), steps);
    ASSERT_TRUE(found);
    double mean = 0.0;  // ln, of the steps that are asked
    for (const int step : steps)
      for (const int pitch : {0, 12})
        mean += std::log(truth[static_cast<std::size_t>(pitch + step)]) /
                (2.0 * static_cast<double>(steps.size()));
    CameraImages others = images;
    for (std::size_t k = 0; k < truth.size(); ++k)
      if (std::ranges::find(steps, static_cast<int>(k % 12)) == steps.end()) {
        EXPECT_EQ(found->factor[k], 1.0);
        EXPECT_EQ(found->sigma[k], 0.0);
        for (float& v : others.images[k].as_floats()) v = 255.0F - v;
      } else {
        EXPECT_NEAR(std::log(found->factor[k]), std::log(truth[k]) - mean, 4.0 * found->sigma[k]) << k;
        EXPECT_LT(found->sigma[k], 3e-3);
        EXPECT_GT(found->sigma[k], 0.0);
      }
    EXPECT_TRUE(std::isnan(found->phase_rms_rad));
    EXPECT_NEAR(found->residual_after, 1.0, 0.15);
    const auto again = estimate_light(others, fringes, of(scene), steps);
    ASSERT_TRUE(again);
    EXPECT_EQ(found->factor, again->factor);
    EXPECT_EQ(found->waveform, again->waveform);
  }
  EXPECT_FALSE(estimate_light(images, fringes, of(scene), {0, 4, 8}));
}

TEST(LightFactors, AreFoundForAnyNumberOfSteps) {
  for (const int n : {4, 5, 6, 7, 8, 12, 16})
    for (const double gamma : {1.0, 1.6}) {
      SCOPED_TRACE(::testing::Message() << n << " steps, gamma " << gamma);
      const Fringes fringes = fringes_of(n, {13.0, 17.0});
      const std::vector<double> truth = flicker(static_cast<std::size_t>(2 * n), static_cast<unsigned>(n));
      const Scene scene{.gamma = gamma, .has_glare = true};
      const auto found = estimate_light(record(scene, fringes, truth, 3), fringes, of(scene));
      ASSERT_TRUE(found);
      expect_found(*found, truth, 2e-3);
      EXPECT_TRUE(found->differ());
      EXPECT_GT(found->residual_before, 2.0 * found->residual_after);
      // noise and rounding are what is left: 6500 pixels of N - 3 numbers each
      EXPECT_NEAR(found->residual_after, 1.0, 0.15);
    }
}

TEST(LightFactors, HarmonicsAreNotTakenForLight) {
  for (const int n : {4, 5, 6, 8}) {
    const Fringes fringes = fringes_of(n, {16.0});
    const std::vector<double> steady(static_cast<std::size_t>(n), 1.0);
    const Scene scene{.gamma = 2.2};
    const auto found = estimate_light(record(scene, fringes, steady, 5), fringes, of(scene));
    ASSERT_TRUE(found);
    expect_found(*found, steady, 2e-3);
    EXPECT_FALSE(found->differ()) << n;
  }
}

// A change that goes j times up and down over the steps: for j = 1 it hides in the pixels' own sinusoids but
// for what it does to the fringe's contrast, for j = 2 it is what a second harmonic leaves.
TEST(LightFactors, EachFrequencyIsFound) {
  for (const int n : {4, 8})
    for (int j = 1; j <= n / 2; ++j) {
      SCOPED_TRACE(::testing::Message() << j << " of " << n);
      const Fringes fringes = fringes_of(n, {14.0});
      std::vector<double> truth;
      for (int k = 0; k < n; ++k) truth.push_back(std::exp(0.01 * std::cos(2.0 * kPi * j * k / n + 0.3)));
      const Scene scene{.gamma = 1.3};
      const auto found = estimate_light(record(scene, fringes, truth, 9), fringes, of(scene));
      ASSERT_TRUE(found);
      expect_found(*found, truth, 2e-3);
      EXPECT_TRUE(found->differ());
    }
}

// A pixel's bright values have more shot noise than its dark ones, whatever its weight.
TEST(LightFactors, SigmaIsThatOfTheScatter) {
  struct Set {
    int n;
    std::vector<double> pitches_px;
    double electrons_per_dn;
  };
  const std::vector<Set> sets{{6, {11.0, 13.0}, 0.0}, {6, {11.0, 13.0, 16.0}, 4.0}, {12, {11.0}, 4.0}};
  for (const auto& [n, pitches_px, electrons_per_dn] : sets) {
    SCOPED_TRACE(::testing::Message() << n << " steps, pitches: " << pitches_px.size());
    const Fringes fringes = fringes_of(n, pitches_px);
    const std::vector<double> truth = flicker(static_cast<std::size_t>(n) * pitches_px.size(), 21, 0.01);
    const Scene scene{.width = 40, .height = 40, .electrons_per_dn = electrons_per_dn};
    std::vector<double> squares(pitches_px.size(), 0.0);
    for (unsigned seed = 0; seed < 200; ++seed) {
      const auto found = estimate_light(record(scene, fringes, truth, seed), fringes, of(scene));
      ASSERT_TRUE(found);
      for (std::size_t k = 0; k < truth.size(); ++k)
        squares[k / static_cast<std::size_t>(n)] +=
            std::pow(std::log(found->factor[k] / truth[k]) / found->sigma[k], 2) / (200.0 * n);
    }
    for (std::size_t p = 0; p < squares.size();
         ++p)  // 1200 values: 1/sqrt(2 * 1200) = 0.02; three times that
      EXPECT_NEAR(std::sqrt(squares[p]), 1.0, 0.06) << "pitch " << p;
    std::printf("%d steps, %zu pitches: rms z of the first %.3f\n", n, pitches_px.size(),
                std::sqrt(squares[0]));
  }
}

TEST(LightFactors, WhatTheStepsDoNotTell) {
  const Scene scene, one_phase{.phase_per_px = 0.0}, small{.width = 12, .height = 12};
  const std::vector<double> three(3, 1.0), four(4, 1.0);
  const Fringes fringes = fringes_of(4, {14.0});
  EXPECT_FALSE(
      estimate_light(record(scene, fringes_of(3, {14.0}), three, 1), fringes_of(3, {14.0}), of(scene)));
  EXPECT_FALSE(estimate_light(record(one_phase, fringes, four, 1), fringes, of(one_phase)));
  EXPECT_FALSE(estimate_light(record(small, fringes, four, 1), fringes, of(small)));
  LightOptions dark = of(scene);
  dark.min_amplitude = 500.0;
  EXPECT_FALSE(estimate_light(record(scene, fringes, four, 1), fringes, dark));
}

// A pitch of 20 periods of the image's width is seen at a twentieth of its phases: its images have no
// factors, those of the fine one are what they are without it.
TEST(LightFactors, AWidePitchThatIsNotToldLeavesTheFineOne) {
  const Fringes fringes = fringes_of(6, {14.0, 4800.0}), fine = fringes_of(6, {14.0});
  const Scene scene;
  CameraImages images = record(scene, fringes, flicker(12, 6), 3);
  const auto found = estimate_light(images, fringes, of(scene));
  ASSERT_TRUE(found);
  images.images.resize(6);
  const auto alone = estimate_light(images, fine, of(scene));
  ASSERT_TRUE(alone);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(found->factor[k], alone->factor[k]);
    EXPECT_EQ(found->sigma[k], alone->sigma[k]);
    EXPECT_EQ(found->factor[6 + k], 1.0);
    EXPECT_EQ(found->sigma[6 + k], std::numeric_limits<double>::infinity());
  }
  EXPECT_TRUE(found->differ());
  EXPECT_EQ(found->phase_rms_rad, alone->phase_rms_rad);
  EXPECT_EQ(largest_told(found->sigma), largest_told(alone->sigma));
}

// Fringes that lie within one block of the image: their means tell the pitches' levels, but nothing tells how
// well.
TEST(LightFactors, LevelsOfOneBlockHaveNoStandardError) {
  constexpr int kLit = 40;  // px of 640: a block
  const Fringes fringes = fringes_of(6, {13.0, 17.0});
  Scene scene{.width = 640, .height = 8};
  CameraImages images = record(scene, fringes, flicker(12, 6), 3);
  for (GrayImage& image : images.images) {
    ImageF lit(scene.width, scene.height, static_cast<float>(scene.black_dn));
    for (int y = 0; y < scene.height; ++y)
      for (int x = 0; x < kLit; ++x) lit(x, y) = image(200 + x, y);
    image = std::move(lit);
  }
  const auto found = estimate_light(images, fringes, of(scene));
  ASSERT_TRUE(found);
  for (const double sigma : found->sigma) EXPECT_EQ(sigma, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(found->differ());
  images.images.resize(6);  // one pitch has no level to tell: its factors are of themselves
  const auto one = estimate_light(images, fringes_of(6, {13.0}), of(scene));
  ASSERT_TRUE(one);
  for (const double sigma : one->sigma) EXPECT_LT(sigma, 5e-3);
  EXPECT_TRUE(one->differ());
}

TEST(LightFactors, OptionsHaveTheBlackLevelAndTheNoiseOfTheSensor) {
  Sensor sensor;
  sensor.black_level_dn = 12.0;
  EXPECT_EQ(light_options(sensor, 3.0), (LightOptions{.black_level_dn = 12.0, .min_amplitude = 3.0}));
  sensor.read_noise_dn = 0.5;
  sensor.electrons_per_dn = 40.0;
  const LightOptions stated = light_options(sensor, 3.0);
  EXPECT_EQ(stated.black_level_dn, 12.0);
  EXPECT_EQ(stated.min_amplitude, 3.0);
  const auto variance = [&](double dn) { return stated.variance_offset_dn2 + stated.variance_per_dn * dn; };
  // read noise and rounding at black, shot noise of 40 electrons per DN above it
  EXPECT_NEAR(variance(12.0), 0.25 + 1.0 / 12.0, 1e-12);
  EXPECT_NEAR(variance(212.0), 0.25 + 1.0 / 12.0 + 200.0 / 40.0, 1e-12);
}

TEST(LightFactors, AnyNumberOfThreadsTellsTheSame) {
  const Fringes fringes = fringes_of(5, {13.0, 17.0});
  const Scene scene;
  const CameraImages images = record(scene, fringes, flicker(10, 4), 8);
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const auto one = estimate_light(images, fringes, of(scene));
  omp_set_num_threads(3);
  const auto three = estimate_light(images, fringes, of(scene));
  omp_set_num_threads(before);
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->factor, three->factor);
  EXPECT_EQ(one->sigma, three->sigma);
}

// The N-step phase of a fringe under such light, against that under steady light.
TEST(LightFactors, PhaseThatLightMoves) {
  for (const int n : {3, 4, 5, 8, 12}) {
    const std::vector<double> factors = flicker(static_cast<std::size_t>(n), 17, 0.01);
    constexpr double kRatio = 1.3;
    constexpr int kPhases = 720;
    double mean = 0.0, squares = 0.0;
    for (int i = 0; i < kPhases; ++i) {
      const double phase = 2.0 * kPi * i / kPhases;
      std::complex<double> sum;
      for (int k = 0; k < n; ++k) {
        const double delta = 2.0 * kPi * k / n;
        sum += factors[static_cast<std::size_t>(k)] * (kRatio + std::cos(phase + delta)) *
               std::polar(1.0, -delta);
      }
      const double moved = std::arg(sum * std::polar(1.0, -phase));
      mean += moved / kPhases, squares += moved * moved / kPhases;
    }
    EXPECT_NEAR(light_phase_rms_rad(factors, kRatio), std::sqrt(squares),
                0.01 * std::sqrt(squares) + mean * mean)
        << n;
  }
}

TEST(LightFactors, AreTakenOutAndClipsStay) {
  const Fringes fringes = fringes_of(4, {14.0});
  const Scene quiet{.noise_dn = 0.0, .has_glare = true};
  const std::vector<double> truth = flicker(4, 2, 0.05);
  const CameraImages images = record(quiet, fringes, truth, 1);
  const LightFactors light{.factor = truth, .sigma = std::vector<double>(4, 1e-4)};
  const CameraImages steady = with_steady_light(images, light, quiet.black_dn);
  std::size_t n_clipped = 0;
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < images.images[k].size(); ++i) {
      const auto before = static_cast<double>(images.images[k][i]),
                 after = static_cast<double>(steady.images[k][i]);
      ASSERT_EQ(before >= images.saturation_dn(), after >= steady.saturation_dn());
      if (before >= images.saturation_dn())
        ++n_clipped;
      else
        ASSERT_NEAR(after, quiet.black_dn + (before - quiet.black_dn) / truth[k], 2e-6 * 255.0);
    }
  EXPECT_GT(n_clipped, 0u);
}

}  // namespace
}  // namespace fringetwin::measure::light_factors_test
