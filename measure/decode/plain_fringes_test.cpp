// SPDX-License-Identifier: Apache-2.0
// Harmonics, light and shifts that are planted into fringes of plain numbers are taken out of some of their
// steps.
//
// | check                | tolerance      | origin                                                          |
// |----------------------|----------------|-----------------------------------------------------------------|
// | phase of six steps   | 1.05 x noise   | rms of 7680 phases: 0.8 %, and what 23 numbers are not known by |
// | ripple as recorded   | > 3 x noise    | planted: orders 5 and 7 of 2 and 1 %, 0.02 rad; shifts: 0.015   |
// | without noise        | 2e-4 rad       | gray values in single precision, and what four passes leave     |
// | form over the image  | 1.5e-3 rad     | the light, told beside one form for all, is wrong by 1e-3       |
#include "measure/decode/plain_fringes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "measure/decode/phase.hpp"
#include "twin/image/rows_of_images.hpp"

namespace fringetwin::measure::plain_fringes_test {
namespace {

constexpr int kWidth = 96, kHeight = 80, kSteps = 12;
constexpr double kAmplitude = 60.0, kMean = 100.0, kBlack = 6.0;
constexpr double kPi = std::numbers::pi;

const Fringes kFringes{
    .directions = {{Axis::x, {16.0}, {0.0}, {}}}, .steps = kSteps, .unwrap = Unwrap::none, .images = {}};

double phase_rad(int x, int y) { return 0.37 * x + 0.011 * y; }

/// Returns a shift of a step besides the mean and the first harmonic of all: orders 2 and 5 of 0.04 rad, or
/// the former alone, which has none over two of every three steps either.
double planted_shift_rad(int n, bool with_fifth = true) {
  return 0.04 * (std::sin(1.0 + 4.0 * kPi * n / kSteps) +
                 (with_fifth ? std::cos(0.5 + 10.0 * kPi * n / kSteps) : 0.0));
}

/// Returns the images of a lamp that flickers, of fringes with harmonics, with noise. `varies`: by how much
/// more the orders 5 and 7 differ over the image.
CameraImages recorded(double noise_dn, bool is_shifted = false, double varies = 0.0, bool with_fifth = true) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  CameraImages out;
  out.bit_depth = 12;
  for (int n = 0; n < kSteps; ++n) {
    const double factor = 1.0 + 0.02 * std::sin(1.0 + 2.3 * n);
    ImageF image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double t = phase_rad(x, y) + 2.0 * kPi * n / kSteps +
                         (is_shifted ? planted_shift_rad(n, with_fifth) : 0.0),
                     u = 2.0 * (x + 0.5) / kWidth - 1.0, v = 2.0 * (y + 0.5) / kHeight - 1.0,
                     fifth = varies * (u - 0.5 * u * v), seventh = varies * (0.3 * v + 0.4 * u * u),
                     wave = std::cos(t) + 0.05 * std::cos(2.0 * t) + 0.02 * std::cos(5.0 * t) -
                            0.01 * std::sin(7.0 * t) + fifth * std::sin(5.0 * t) +
                            seventh * std::cos(7.0 * t);
        image(x, y) =
            static_cast<float>(kBlack + factor * (kMean + kAmplitude * wave) + noise_dn * noise(random));
      }
    out.images.push_back(std::move(image));
  }
  return out;
}

/// Returns the rms of what these steps' phases are wrong by.
double wrong_by_rad(const CameraImages& images, const std::vector<int>& steps) {
  const StepSolver solver(steps, kSteps);
  std::vector<const float*> of_step;
  RowsOfImages rows;
  for (const int n : steps) of_step.push_back(rows.whole(images.images[static_cast<std::size_t>(n)]));
  std::vector<float> phase(static_cast<std::size_t>(kWidth) * kHeight);
  solve_row(solver, of_step.data(), kWidth * kHeight, {.phase_rad = phase.data()});
  double sum = 0.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      sum += std::pow(std::remainder(static_cast<double>(phase[static_cast<std::size_t>(y * kWidth + x)]) -
                                         phase_rad(x, y),
                                     2.0 * kPi),
                      2);
  return std::sqrt(sum / (kWidth * kHeight));
}

TEST(PlainFringes, HaveThePhasesOfASteadyLightAndASinusoid) {
  const std::vector<int> even{0, 2, 4, 6, 8, 10}, uneven{0, 1, 3, 4, 7, 10, 11};
  const LightOptions options{.black_level_dn = kBlack, .variance_offset_dn2 = 0.25};
  for (const double noise_dn : {0.0, 0.5}) {
    const CameraImages images = recorded(noise_dn);
    const auto light = estimate_light(images, kFringes, options);
    ASSERT_TRUE(light);
    ASSERT_EQ(light->waveform.size(), 1u);
    for (const std::vector<int>& steps : {even, uneven}) {
      double variance = 0.0;  // of a phase, mean over all phases
      const StepSolver solver(steps, kSteps);
      for (int k = 0; k < 64; ++k)
        variance += solver.phase_variance(std::cos(k * kPi / 32.0), std::sin(k * kPi / 32.0)) / 64.0;
      const double noise_rad = noise_dn / kAmplitude * std::sqrt(variance);
      const double before = wrong_by_rad(images, steps),
                   after = wrong_by_rad(with_plain_fringes(images, kFringes, *light, options, steps), steps);
      EXPECT_GT(before, 3.0 * noise_rad);
      EXPECT_LT(after, noise_dn > 0.0 ? 1.05 * noise_rad : 2e-4);
    }
  }
}

// Of a form that differs over the image, as of one that is the same all over.
TEST(PlainFringes, HaveTheirFormFromTheirPlace) {
  const std::vector<int> even{0, 2, 4, 6, 8, 10};
  const LightOptions options{.black_level_dn = kBlack, .variance_offset_dn2 = 0.25};
  for (const double noise_dn : {0.0, 0.5}) {
    const CameraImages images = recorded(noise_dn, false, 0.03);
    const auto light = estimate_light(images, kFringes, options);
    ASSERT_TRUE(light);
    const double noise_rad = noise_dn / kAmplitude * std::sqrt(2.0 / 6.0),
                 before = wrong_by_rad(images, even),
                 after = wrong_by_rad(with_plain_fringes(images, kFringes, *light, options, even), even);
    EXPECT_GT(before, 0.015);
    EXPECT_LT(after, noise_dn > 0.0 ? 1.05 * noise_rad : 1.5e-3);
  }
}

TEST(PlainFringes, LieAtTheirSteps) {
  const std::vector<int> even{0, 2, 4, 6, 8, 10};
  const LightOptions blind{.black_level_dn = kBlack, .variance_offset_dn2 = 0.25};
  LightOptions options = blind;
  options.with_shifts = true;
  for (const double noise_dn : {0.0, 0.5}) {
    const CameraImages images = recorded(noise_dn, true);
    const auto light = estimate_light(images, kFringes, options);
    ASSERT_TRUE(light);
    EXPECT_TRUE(light->are_shifted());
    for (int n = 0; n < kSteps; ++n) {
      const auto k = static_cast<std::size_t>(n);
      EXPECT_NEAR(light->shift_rad[k], planted_shift_rad(n), 4.0 * light->shift_sigma_rad[k] + 2e-5) << n;
      EXPECT_LT(light->shift_sigma_rad[k], noise_dn > 0.0 ? 3e-4 : 1e-5);  // 0.5/60 of 7680 pixels: 1e-4 each
      EXPECT_NEAR(std::log(light->factor[k] / light->factor[0]),
                  std::log((1.0 + 0.02 * std::sin(1.0 + 2.3 * n)) / (1.0 + 0.02 * std::sin(1.0))),
                  6.0 * light->sigma[k] + 2e-5)
          << n;
    }
    const double noise_rad = noise_dn / kAmplitude * std::sqrt(2.0 / 6.0);
    EXPECT_LT(wrong_by_rad(with_plain_fringes(images, kFringes, *light, options, even), even),
              noise_dn > 0.0 ? 1.05 * noise_rad : 2e-4);
    const auto without = estimate_light(images, kFringes, blind);
    ASSERT_TRUE(without);
    EXPECT_GT(wrong_by_rad(with_plain_fringes(images, kFringes, *without, blind, even), even),
              noise_dn > 0.0 ? 3.0 * noise_rad : 0.01);
  }
  // two thirds of the steps tell it alone
  const std::vector<int> some{0, 1, 3, 4, 6, 7, 9, 10};
  for (const double noise_dn : {0.0, 0.5}) {
    const CameraImages images = recorded(noise_dn, true, 0.0, false);
    const auto light = estimate_light(images, kFringes, options, some);
    ASSERT_TRUE(light);
    EXPECT_TRUE(light->are_shifted());
    for (const int n : some) {
      const auto k = static_cast<std::size_t>(n);
      EXPECT_NEAR(light->shift_rad[k], planted_shift_rad(n, false), 4.0 * light->shift_sigma_rad[k] + 2e-5)
          << n;
    }
    const double noise_rad = noise_dn / kAmplitude * std::sqrt(2.0 / 8.0);
    EXPECT_LT(wrong_by_rad(with_plain_fringes(images, kFringes, *light, options, some), some),
              noise_dn > 0.0 ? 1.05 * noise_rad : 2e-4);
  }
  // fringes that are not shifted are not
  const auto straight = estimate_light(recorded(0.5), kFringes, options);
  ASSERT_TRUE(straight);
  EXPECT_FALSE(straight->are_shifted());
}

TEST(PlainFringes, LeaveOtherStepsAndClippedPixelsAlone) {
  CameraImages images = recorded(0.0);
  images.bit_depth = 8;
  images.images[4].writable(10, 10) = 255.0F;
  const LightOptions options{.black_level_dn = kBlack};
  auto light = estimate_light(images, kFringes, options);
  ASSERT_TRUE(light);
  for (double& factor : light->factor) factor = 1.0;
  const CameraImages plain = with_plain_fringes(images, kFringes, *light, options, {0, 2, 4, 6, 8, 10});
  EXPECT_EQ(plain.images[1].floats().data, images.images[1].floats().data);
  EXPECT_NE(plain.images[2].floats().data, images.images[2].floats().data);
  EXPECT_EQ(plain.images[2](10, 10), images.images[2](10, 10));
}

}  // namespace
}  // namespace fringetwin::measure::plain_fringes_test
