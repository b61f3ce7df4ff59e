// SPDX-License-Identifier: Apache-2.0
// Waveforms that vary over an image of plain numbers are found, where they do and as far as they do.
//
// | check                  | tolerance | origin                                                  |
// |------------------------|-----------|---------------------------------------------------------|
// | field, without noise   | 2e-5      | the last step is below 1e-5, and so is what comes after |
// | field, with noise, rms | 1.3 sigma | 72 and 180 numbers: 1 + 3/sqrt(2 n) = 1.25 and 1.16     |
// | the same all over      | 1.61      | 12 numbers: 1 + 3/sqrt(24)                              |
// | two forms, an edge     | 0.6       | of the mean form's rms; a quartic leaves 0.45 of a step |
#include "measure/light/waveform_field.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace fringetwin::measure::waveform_field_test {
namespace {

constexpr int kWidth = 200, kHeight = 150, kSteps = 12;
constexpr double kAmplitude = 60.0, kMean = 100.0, kBlack = 6.0, kPi = std::numbers::pi;

/// Of the fifth harmonic (cosine) and the seventh (sine) at u, v from -1 to 1.
using Form = std::function<std::pair<double, double>(double u, double v)>;

std::pair<double, double> place(int x, int y) {
  return {2.0 * (x + 0.5) / kWidth - 1.0, 2.0 * (y + 0.5) / kHeight - 1.0};
}

std::vector<GrayImage> recorded(const Form& form, double noise_dn) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<GrayImage> out;
  for (int n = 0; n < kSteps; ++n) {
    ImageF image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const auto [u, v] = place(x, y);
        const auto [fifth, seventh] = form(u, v);
        const double t = 0.37 * x + 0.011 * y + 2.0 * kPi * n / kSteps;
        image(x, y) = static_cast<float>(
            kBlack + kMean +
            kAmplitude * (std::cos(t) + fifth * std::cos(5.0 * t) + seventh * std::sin(7.0 * t)) +
            noise_dn * noise(random));
      }
    out.push_back(std::move(image));
  }
  return out;
}

WaveformField field_of(const std::vector<GrayImage>& images,
                       const std::vector<double>& given = std::vector<double>(12, 0.0)) {
  PitchImages of_steps{.steps_total = kSteps};
  for (const GrayImage& image : images) {
    of_steps.step.push_back(static_cast<int>(of_steps.step.size()));
    of_steps.image.push_back(&image);
    of_steps.shift_rad.push_back(0.0);
  }
  const LightOptions options{.black_level_dn = kBlack, .variance_offset_dn2 = 0.25};
  return {of_steps, given, options, 255.0};
}

/// Returns the rms of what the harmonics 2 ... 7 are wrong by over the image.
double wrong_by(const WaveformField& field, const Form& form) {
  double sum = 0.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      Eigen::VectorXd wrong = field.at(static_cast<std::size_t>(y * kWidth + x));
      const auto [u, v] = place(x, y);
      const auto [fifth, seventh] = form(u, v);
      wrong[6] -= fifth;
      wrong[11] -= seventh;
      sum += wrong.squaredNorm();
    }
  return std::sqrt(sum / (12.0 * kWidth * kHeight));
}

TEST(WaveformField, IsFoundUpToTheFourthOrder) {
  const Form quadratic =
                 [](double u, double v) {
                   return std::pair{0.02 + 0.03 * u * u, 0.01 * u * v};
                 },
             quartic = [](double u, double v) {
               return std::pair{0.02 - 0.02 * u * u * u * v + 0.01 * v * v * v, 0.02 * u * u * v * v};
             };
  for (const auto& [form, n_terms] : {std::pair{quadratic, 6.0}, std::pair{quartic, 15.0}}) {
    const WaveformField exact = field_of(recorded(form, 0.0));
    EXPECT_TRUE(exact.varies());
    EXPECT_LT(wrong_by(exact, form), 2e-5);
    const double noise_dn = 0.5, of_term = noise_dn / kAmplitude * std::sqrt(2.0 / 12.0 / (kWidth * kHeight));
    const WaveformField noisy = field_of(recorded(form, noise_dn));
    // orders that tell no more than chance are left alone
    EXPECT_LT(wrong_by(noisy, form), 1.3 * of_term * std::sqrt(n_terms));
  }
}

TEST(WaveformField, IsTheSameAllOverWhereNothingVaries) {
  const Form even = [](double, double) { return std::pair{0.02, -0.01}; };
  const double of_term = 0.5 / kAmplitude * std::sqrt(2.0 / 12.0 / (kWidth * kHeight));
  const WaveformField field = field_of(recorded(even, 0.5));
  EXPECT_FALSE(field.varies());
  EXPECT_LT(wrong_by(field, even), 1.61 * of_term);  // 12 numbers, the same all over: 1 + 3/sqrt(24)
}

// A third of the image shows another form, with an edge between: that is no polynomial, but no pixel is left
// out of it, and neither part is worse off than by the mean form.
TEST(WaveformField, HoldsWhatFewPixelsShow) {
  const Form two = [](double u, double) { return std::pair{u > 0.3 ? 0.05 : 0.0, 0.0}; };
  const WaveformField field = field_of(recorded(two, 0.5));
  EXPECT_TRUE(field.varies());
  const double mean_form = 0.05 * std::sqrt(0.35 * 0.65 / 12.0);
  EXPECT_LT(wrong_by(field, two), 0.6 * mean_form);
}

// A lit part in a corner has all terms, which go no farther than it does.
TEST(WaveformField, IsThatOfTheLitPart) {
  const Form form = [](double u, double v) {
    return std::pair{0.02 + 0.05 * (u - 0.4) * (u - 0.8) * v, 0.0};
  };
  std::vector<GrayImage> images = recorded(form, 0.0);
  for (GrayImage& image : images)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (x < 110 || y < 80) image.writable(x, y) = static_cast<float>(kBlack);
  const WaveformField field = field_of(images);
  const auto [u, v] = place(150, 120);
  EXPECT_NEAR(field.at(120 * kWidth + 150)[6], form(u, v).first, 2e-5);
  EXPECT_LT(field.at(0).cwiseAbs().maxCoeff(), 0.1);
}

TEST(WaveformField, IsTheSameWithAnyNumberOfThreads) {
  const Form form = [](double u, double v) { return std::pair{0.02 + 0.03 * u * u * u, 0.01 * v}; };
  const std::vector<GrayImage> images = recorded(form, 0.5);
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const Eigen::VectorXd alone = field_of(images).at(777);
  omp_set_num_threads(3);
  const Eigen::VectorXd together = field_of(images).at(777);
  omp_set_num_threads(before);
  EXPECT_EQ(alone, together);
}

TEST(WaveformField, IsTheOneGivenWhereTooLittleIsLit) {
  std::vector<GrayImage> dark = recorded([](double, double) { return std::pair{0.02, 0.0}; }, 0.0);
  for (GrayImage& image : dark)
    for (std::size_t i = 1000; i < image.size(); ++i) image.as_floats()[i] = static_cast<float>(kBlack);
  const std::vector<double> given{0.01, 0.0, 0.0, -0.02, 0.0, 0.0, 0.005, 0.0, 0.0, 0.0, 0.0, 0.001};
  const WaveformField field = field_of(dark, given);
  EXPECT_FALSE(field.varies());
  EXPECT_EQ(field.at(0), Eigen::Map<const Eigen::VectorXd>(given.data(), 12));
}

}  // namespace
}  // namespace fringetwin::measure::waveform_field_test
