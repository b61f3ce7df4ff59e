// SPDX-License-Identifier: Apache-2.0
// | tolerance      | unit     | origin                                                             |
// |----------------|----------|--------------------------------------------------------------------|
// | 0              | DN       | without noise the formula is exact                                  |
// | 4.5 sigma      | of stat. | standard error of mean (s/sqrt n), variance (s^2 sqrt(2/n)),        |
// |                |          | correlation (1/sqrt n) with n = 200,000; fixed seeds                |
// | Sheppard       | DN^2     | rounding adds 1/12 DN^2 to the variance of a wide Gaussian          |
#include "render/sensor/sensor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "render/base/normal_deviates.hpp"
#include "render/base/philox.hpp"
#include "render/reference/reference_sensor.hpp"

namespace fringetwin::render::sensor_test {
namespace {

Sensor make_sensor(int bits, double gain, double black = 0.0, std::optional<double> electrons_per_dn = {},
                   std::optional<double> read_noise_dn = {}) {
  return {bits, {}, gain, black, electrons_per_dn, read_noise_dn};
}

constexpr int width = 500, height = 400;
constexpr double n_pixels = width * height;

struct Statistics {
  double mean = 0.0, variance = 0.0, kurtosis = 0.0;
};
Statistics statistics(const ImageF& image) {
  Statistics s;
  for (float v : image.data) s.mean += v;
  s.mean /= n_pixels;
  double fourth = 0.0;
  for (float v : image.data) {
    const double d = v - s.mean;
    s.variance += d * d;
    fourth += d * d * d * d;
  }
  s.variance /= n_pixels;
  s.kurtosis = fourth / n_pixels / (s.variance * s.variance);
  return s;
}
double correlation(const ImageF& a, const ImageF& b, std::size_t shift = 0) {
  const Statistics sa = statistics(a), sb = statistics(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (a.data[i] - sa.mean) * (b.data[(i + shift) % b.size()] - sb.mean);
  return sum / n_pixels / std::sqrt(sa.variance * sb.variance);
}
ImageF uniform(double value) { return {width, height, static_cast<float>(value)}; }

// Known answers of the authors' Random123 distribution (kat_vectors, philox4x32 10).
TEST(Philox, KnownAnswers) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}),
            (PhiloxCounter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}),
            (PhiloxCounter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (PhiloxCounter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Expose, WithoutNoiseTheFormulaIsExact) {
  const Sensor sensor = make_sensor(8, 20.0, 2.5);
  ImageF e(6, 1);
  e.data = {0.0f, 1.0f, 2.0374f, 5.0f, 12.6f, 100.0f};
  EXPECT_THAT(expose(e, sensor, 1, 0, 0).data, ::testing::ElementsAre(3, 23, 43, 103, 255, 255));
  const Sensor dark = make_sensor(8, 1.0, -10.0);
  EXPECT_EQ(expose(e, dark, 1, 0, 0).data[1], 0.0f);
}

TEST(Expose, InvalidStaysInvalid) {
  ImageF e(2, 1);
  e.data = {std::numeric_limits<float>::quiet_NaN(), 1.0f};
  const ImageF dn = expose(e, make_sensor(8, 20.0), 1, 0, 0);
  EXPECT_TRUE(std::isnan(dn.data[0]));
  EXPECT_EQ(dn.data[1], 20.0f);
  const ImageF noisy = expose(e, make_sensor(8, 20.0, 0.0, 40.0, 0.1), 1, 0, 0);
  EXPECT_TRUE(std::isnan(noisy.data[0]));
  EXPECT_NEAR(noisy.data[1], 20.0f, 5.0f);  // 7 sigma
}

TEST(Expose, EveryBitDepthClampsAtItsTop) {
  for (int bits : {8, 10, 12, 16}) {
    const double top = std::pow(2.0, bits) - 1;
    const Sensor sensor = make_sensor(bits, top);
    ImageF e(4, 1);
    e.data = {0.0f, 0.5f, 1.0f, 1.5f};
    EXPECT_THAT(expose(e, sensor, 1, 0, 0).data,
                ::testing::ElementsAre(0.0f, static_cast<float>(std::round(top / 2)), static_cast<float>(top),
                                       static_cast<float>(top)))
        << bits;
  }
}

TEST(Expose, RoundsToTheNearestLevelWithoutBias) {
  const Sensor sensor = make_sensor(16, 1.0);
  ImageF ramp(10000, 1);
  double error = 0.0;
  for (int i = 0; i < 10000; ++i) ramp.data[i] = static_cast<float>(1000.0 + i * 0.01037);
  const ImageF dn = expose(ramp, sensor, 1, 0, 0);
  for (int i = 0; i < 10000; ++i) {
    EXPECT_LE(std::abs(dn.data[i] - ramp.data[i]), 0.5f);
    error += dn.data[i] - ramp.data[i];
  }
  EXPECT_NEAR(error / 10000, 0.0, 2e-3);
}

// variance = gain E / electrons_per_dn + read^2 + 1/12 (rounding); the black level makes no noise
TEST(Expose, MeanAndVarianceFollowTheModel) {
  struct Case {
    int bits;
    double gain, e, black, electrons, read;
  };
  for (const Case& c : {Case{8, 20.0, 5.0, 10.0, 40.2, 0.6},
                        {10, 100.0, 4.0, 64.0, 10.0, 1.0},
                        {12, 1.0, 2000.0, 240.0, 4.0, 2.5},
                        {16, 500.0, 60.0, 1000.0, 0.25, 8.0}}) {
    const Sensor sensor = make_sensor(c.bits, c.gain, c.black, c.electrons, c.read);
    const Statistics s = statistics(expose(uniform(c.e), sensor, 7, 0, 3));
    const double variance = c.gain * c.e / c.electrons + c.read * c.read + 1.0 / 12.0;
    EXPECT_NEAR(s.mean, c.gain * c.e + c.black, 4.5 * std::sqrt(variance / n_pixels)) << c.bits;
    EXPECT_NEAR(s.variance, variance, 4.5 * variance * std::sqrt(2.0 / n_pixels)) << c.bits;
    EXPECT_NEAR(s.kurtosis, 3.0, 4.5 * std::sqrt(24.0 / n_pixels) + 0.02) << c.bits;
  }
}

// DN = black + f(gain E), f written out by hand: slope 1 to 100 DN, 0.8 beyond. The light's shot noise goes
// through the curve: its variance is f'^2 times that of the light.
TEST(Expose, ResponseBendsSignalAndShotNoiseAlike) {
  Sensor sensor = make_sensor(8, 20.0, 10.0);
  sensor.response = knee_response(100.0, 0.8);
  ImageF e(5, 1);
  e.data = {0.0F, 2.5F, 5.0F, 7.5F, 20.0F};
  EXPECT_THAT(expose(e, sensor, 1, 0, 0).data, ::testing::ElementsAre(10.0F, 60.0F, 110.0F, 150.0F, 255.0F));
  sensor.electrons_per_dn = 8.0, sensor.read_noise_dn = 2.0;
  const Statistics s = statistics(expose(uniform(7.5), sensor, 7, 0, 3));
  const double variance = 0.8 * 0.8 * 150.0 / 8.0 + 2.0 * 2.0 + 1.0 / 12.0;
  EXPECT_NEAR(s.mean, 150.0, 4.5 * std::sqrt(variance / n_pixels));
  EXPECT_NEAR(s.variance, variance, 4.5 * variance * std::sqrt(2.0 / n_pixels));
}

// A response that bends nowhere on the way is no response: the same bits.
TEST(Expose, ResponseBelowItsKneeChangesNoBit) {
  Sensor sensor = make_sensor(8, 20.0, 10.0, 8.0, 2.0);
  const ImageF without = expose(uniform(5.0), sensor, 7, 0, 3);
  sensor.response = knee_response(250.0, 0.5);
  EXPECT_EQ(expose(uniform(5.0), sensor, 7, 0, 3).data, without.data);
}

/// A sensor whose pixels differ in gain by 1 % and in black level by 2 DN, with a knee.
Sensor uneven_sensor(int n_columns, int n_rows) {
  Sensor sensor = make_sensor(16, 5000.0, 200.0);
  sensor.response = knee_response(20000.0, 0.7);
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  ImageF factors(n_columns, n_rows), offsets_dn(n_columns, n_rows);
  for (float& factor : factors.data) factor = 1.0F + 0.01F * normal(random);
  for (float& offset_dn : offsets_dn.data) offset_dn = 2.0F * normal(random);
  sensor.prnu.values = std::make_shared<const ImageF>(std::move(factors));
  sensor.dsnu.values = std::make_shared<const ImageF>(std::move(offsets_dn));
  return sensor;
}

// Below and beyond the knee, to the last gray value of 16 bits; a light that the two formulas round to
// different sides is one in 10^8.
TEST(Expose, PixelsOfTheirOwnAreThoseOfTheReference) {
  Sensor sensor = uneven_sensor(width, height);
  ImageF light(width, height);
  for (std::size_t i = 0; i < light.size(); ++i) light.data[i] = 1e-3F * static_cast<float>(i % 9000);
  const auto expect_reference = [&](const std::string& what) {
    const ImageF gray = expose(light, sensor, 1, 0, 0);
    for (std::size_t i = 0; i < light.size(); ++i)
      ASSERT_EQ(gray.data[i],
                std::floor(reference_mean_dn(sensor, static_cast<double>(light.data[i]), i) + 0.5))
          << what << ", pixel " << i;
  };
  expect_reference("factors and offsets");
  const PixelMap offsets = std::exchange(sensor.dsnu, {});
  expect_reference("factors alone");
  sensor.prnu = {}, sensor.dsnu = offsets, sensor.response = {};
  expect_reference("offsets alone");
}

// The shot noise of a pixel is that of its own electrons.
TEST(Expose, NoiseOfAPixelIsThatOfItsOwnGain) {
  Sensor sensor = make_sensor(16, 1000.0, 100.0, 5.0, 3.0);
  sensor.prnu.values = std::make_shared<const ImageF>(width, height, 1.5F);
  sensor.dsnu.values = std::make_shared<const ImageF>(width, height, -40.0F);
  const Statistics s = statistics(expose(uniform(2.0), sensor, 3, 0, 0));
  const double variance = 3000.0 / 5.0 + 9.0 + 1.0 / 12.0;
  EXPECT_NEAR(s.mean, 3060.0, 4.5 * std::sqrt(variance / n_pixels));
  EXPECT_NEAR(s.variance, variance, 4.5 * variance * std::sqrt(2.0 / n_pixels));
  // blocks without light have their offsets, too
  sensor.read_noise_dn.reset();
  EXPECT_THAT(expose(uniform(0.0), sensor, 3, 0, 0).data, ::testing::Each(60.0F));
}

// Maps that change nothing change no bit, with noise and without.
TEST(Expose, PixelsThatAreAllAlikeChangeNoBit) {
  for (const bool noisy : {false, true}) {
    Sensor sensor = noisy ? make_sensor(8, 20.0, 10.0, 8.0, 2.0) : make_sensor(8, 20.0, 10.0);
    const ImageF without = expose(uniform(5.3), sensor, 7, 0, 3);
    sensor.prnu.values = std::make_shared<const ImageF>(width, height, 1.0F);
    sensor.dsnu.values = std::make_shared<const ImageF>(width, height, 0.0F);
    EXPECT_EQ(expose(uniform(5.3), sensor, 7, 0, 3).data, without.data) << noisy;
  }
}

TEST(Expose, ShotAndReadNoiseEachAlone) {
  const Sensor shot = make_sensor(12, 1.0, 0.0, 2.0);
  EXPECT_NEAR(statistics(expose(uniform(1000), shot, 1, 0, 0)).variance, 500.0 + 1.0 / 12,
              4.5 * 500 * std::sqrt(2 / n_pixels));
  EXPECT_EQ(statistics(expose(uniform(0), shot, 1, 0, 0)).variance, 0.0);  // no light, no shot noise
  const Sensor read = make_sensor(12, 1.0, 100, {}, 3.0);
  for (double e : {0.0, 1000.0})
    EXPECT_NEAR(statistics(expose(uniform(e), read, 1, 0, 0)).variance, 9.0 + 1.0 / 12,
                4.5 * 9 * std::sqrt(2 / n_pixels));
}

// To the last pixel, with and without light, beyond saturation, and where a level is rounded half up.
TEST(Expose, NoisyPixelsAreWhatTheFormulaSays) {
  ImageF light(130, 100, 0.0F);  // the last block is not full
  std::mt19937 random(3);
  for (std::size_t i = 2000; i < light.size(); ++i)
    light.data[i] = static_cast<float>(random() % 5000) / 4096.0F;
  light.data[5000] = 1e30F;  // saturated, whatever its noise
  int noisy = 0;
  for (const int bits : {8, 12, 16})
    for (const double black : {0.0, 0.3, 0.49999, 0.5, 10.0, 254.4, 255.0})
      for (const double read : {0.0, 1e-9, 0.1, 0.3, 2.0, 300.0})
        for (const std::optional<double>& electrons : {std::optional<double>{}, {40.0}, {0.2}}) {
          const Sensor sensor = make_sensor(bits, std::exp2(bits) - 1.0, black, electrons, read);
          const ImageF gray = expose(light, sensor, 0x123456789u, 1, 3);
          const DeviateSource source{{0x23456789u, 1}, 3, 1};
          for (std::size_t i = 0; i < light.size(); ++i) {
            const double signal = sensor.gain_dn * static_cast<double>(light.data[i]);
            const double variance = (electrons ? signal / *electrons : 0.0) + read * read;
            double dn = signal + black;
            if (variance > 0.0) dn += std::sqrt(variance) * exact_deviate(source, i);
            const double value = std::floor(std::clamp(dn, 0.0, sensor.max_dn()) + 0.5);
            ASSERT_EQ(gray.data[i], value) << bits << ' ' << black << ' ' << read << " pixel " << i;
            noisy += value == std::floor(std::clamp(signal + black, 0.0, sensor.max_dn()) + 0.5) ? 0 : 1;
          }
        }
  EXPECT_GT(noisy, 1000000) << "most of them have noise";
}

TEST(Expose, SaturationClipsTheUpperHalfOfTheNoise) {
  const Sensor sensor = make_sensor(8, 1.0, 0.0, {}, 4.0);
  const ImageF image = expose(uniform(255.0), sensor, 5, 0, 0);
  int at_top = 0;
  for (float v : image.data) at_top += v == 255.0f;
  // P(round(255 + 4 z) >= 255) = P(z >= -0.125)
  const double expected = 0.5 * std::erfc(-0.125 / std::sqrt(2.0));
  EXPECT_NEAR(at_top / n_pixels, expected, 4.5 * std::sqrt(expected * (1 - expected) / n_pixels));
}

TEST(Expose, PixelsImagesCamerasAndSeedsAreIndependent) {
  const Sensor sensor = make_sensor(16, 1.0, 30000, {}, 500.0);
  const double limit = 4.5 / std::sqrt(n_pixels);
  const ImageF dark = uniform(0.0), base = expose(dark, sensor, 1, 0, 0);
  for (std::size_t shift : {1, 2, 4, width, width + 1})
    EXPECT_NEAR(correlation(base, base, shift), 0.0, limit) << shift;
  EXPECT_NEAR(correlation(base, expose(dark, sensor, 1, 0, 1)), 0.0, limit);
  EXPECT_NEAR(correlation(base, expose(dark, sensor, 1, 1, 0)), 0.0, limit);
  EXPECT_NEAR(correlation(base, expose(dark, sensor, 2, 0, 0)), 0.0, limit);
  EXPECT_NEAR(correlation(base, expose(dark, sensor, 1 + (std::uint64_t{1} << 32), 0, 0)), 0.0, limit);
}

TEST(Expose, TheSameSeedGivesTheSameImageOnAnyNumberOfThreads) {
  const Sensor sensor = make_sensor(12, 1.0, 0.0, 3.0, 2.0);
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const ImageF one = expose(uniform(800), sensor, 42, 1, 5);
  omp_set_num_threads(5);
  const ImageF five = expose(uniform(800), sensor, 42, 1, 5);
  omp_set_num_threads(before);
  EXPECT_EQ(one.data, five.data);
}

RenderedCamera small_rendering() {
  RenderedCamera r;
  r.camera = "left";
  r.irradiance = {ImageF(4, 3, 2.0f), ImageF(4, 3, 3.0f)};
  r.white = ImageF(4, 3, 5.0f);
  r.black = ImageF(4, 3, 0.1f);
  return r;
}

TEST(Expose, AWholeCamera) {
  const Camera camera{"left",
                      Lens("LENSMODEL_PINHOLE", {100, 100, 1.5, 1}, {4, 3}, "test"),
                      {},
                      make_sensor(10, 100.0, 0.0, {}, 5.0),
                      {}};
  const RenderedCamera rendered = small_rendering();
  const CameraImages images = expose(rendered, camera, 1, 9);
  EXPECT_EQ(images.camera, "left");
  EXPECT_EQ(images.bit_depth, 10);
  EXPECT_FALSE(images.radiance);
  ASSERT_EQ(images.images.size(), 2u);
  EXPECT_EQ(images.images[1].floats().data, expose(rendered.irradiance[1], camera.sensor, 9, 1, 1).data);
  ASSERT_TRUE(images.white && images.black);
  EXPECT_NE(images.white->floats().data,
            expose(*rendered.white, camera.sensor, 9, 1, 0).data);  // its own noise
}

TEST(Expose, RadianceKeepsEveryBit) {
  const RenderedCamera rendered = small_rendering();
  const CameraImages images = as_radiance(rendered);
  EXPECT_TRUE(images.radiance);
  EXPECT_EQ(images.images[0].floats().data, rendered.irradiance[0].data);
  EXPECT_TRUE(std::isinf(images.saturation_dn()));
}

}  // namespace
}  // namespace fringetwin::render::sensor_test
