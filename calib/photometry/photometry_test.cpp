// SPDX-License-Identifier: Apache-2.0
// Vignetting and light of drawn images, and what is refused.
//
// | check                     | tolerance | origin                                |
// |---------------------------|-----------|---------------------------------------|
// | vignetting over the image | 0.005     | 4 times a cell mean's noise of 1.2e-3 |
// | light of the images       | 4 sigma   | its own sigma                         |
#include "calib/photometry/photometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/calib/drawn_photometry.hpp"

namespace fringetwin::calib::photometry_test {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// Of one colour of a sensor X, Y and r count from the middle and corners of the whole sensor, as vignetting
// does: the coefficients are those of the sensor. Tolerance: means over cells of other sizes; half a pixel of
// the sensor, the offset of its middle, would be 6e-3 here.
TEST(FlatField, OfOneColourItIsThatOfTheSensor) {
  ImageF flat(81, 61);
  for (int y = 0; y < flat.height; ++y)
    for (int x = 0; x < flat.width; ++x) {
      const double u = (x - 40.0) / 40.5, v = (y - 30.0) / 30.5;
      const double s = (std::pow(x - 40.0, 2) + std::pow(y - 30.0, 2)) / (40.5 * 40.5 + 30.5 * 30.5);
      flat(x, y) = static_cast<float>(180.0 * (1.0 + 0.06 * u - 0.04 * v) * (1.0 - 0.3 * s));
    }
  for (const MosaicColour colour : {MosaicColour::red, MosaicColour::green, MosaicColour::blue}) {
    const MosaicChannel channel{"RGGB", colour, {flat.width, flat.height}};
    const ImageF image = channel_image(flat, channel);
    const FlatField field = fit_flat_field(image, 0.0, 255.0, "left", channel);
    EXPECT_NEAR(field.a[0].value, -0.3, 1e-3) << name_of(colour);
    EXPECT_NEAR(field.gradient_x.value, 0.06, 5e-4);
    EXPECT_NEAR(field.gradient_y.value, -0.04, 5e-4);
    EXPECT_NEAR(light_of(field, image.width, image.height)(3, 4), static_cast<double>(image(3, 4)), 0.05);
  }
}

TEST(FlatField, VignettingUnderUnevenLight) {
  const TrueSensor s{40.0, 0.5, 5.0, 8};
  std::mt19937_64 random(14);
  const auto truth = [](double r2) { return 1.0 - 0.32 * r2 + 0.09 * r2 * r2 - 0.03 * r2 * r2 * r2; };
  ImageF flat(kDrawnWidth, kDrawnHeight);
  const auto r2_of = [](int x, int y) {
    return (std::pow(x - 0.5 * (kDrawnWidth - 1), 2) + std::pow(y - 0.5 * (kDrawnHeight - 1), 2)) /
           (0.25 * (kDrawnWidth * kDrawnWidth + kDrawnHeight * kDrawnHeight));
  };
  for (int y = 0; y < kDrawnHeight; ++y)
    for (int x = 0; x < kDrawnWidth; ++x)
      flat(x, y) = expose(180.0 * truth(r2_of(x, y)) *
                              (1.0 + 0.06 * (x - 0.5 * kDrawnWidth) / kDrawnWidth -
                               0.04 * (y - 0.5 * kDrawnHeight) / kDrawnHeight),
                          s, random);
  const FlatField f = fit_flat_field(flat, 5.0, 255.0, "left");
  for (int y = 0; y < kDrawnHeight; y += 10)
    for (int x = 0; x < kDrawnWidth; x += 10) {
      const double r2 = r2_of(x, y);
      EXPECT_NEAR(1.0 + r2 * (f.a[0].value + r2 * (f.a[1].value + r2 * f.a[2].value)), truth(r2), 0.005);
    }
  EXPECT_NEAR(f.gradient_x.value, 0.03, 4.0 * f.gradient_x.sigma);
  EXPECT_NEAR(f.gradient_y.value, -0.02, 4.0 * f.gradient_y.sigma);
  EXPECT_LT(f.gradient_y.sigma, 0.002) << "else anything would do";
}

TEST(Photometry, LightOfTheImages) {
  TrueFringes f;
  f.gamma = 1.4;
  f.steps = 5;
  f.pitches_px = {16.0, 4.0};
  const TrueSensor s;
  std::mt19937_64 random(17);
  EXPECT_FALSE(
      light_of_images({.cameras = {photometry_of(f, s, {drawn_fringes(f, s, random)})}, .warnings = {}}));
  f.lamp = {0.98, 0.99, 1.0, 1.01, 1.02, 1.02, 0.98, 1.01, 0.99, 1.0};  // a drift, then flicker
  double mean = 0.0;
  for (const double lamp : f.lamp) mean += std::log(lamp) / 10.0;
  Photometry both{.cameras = {photometry_of(f, s, {drawn_fringes(f, s, random)}),
                              photometry_of(f, s, {drawn_fringes(f, s, random)})},
                  .warnings = {}};
  ASSERT_TRUE(both.cameras[0].light && both.cameras[1].light);
  const std::optional<LightOfImages> light = light_of_images(both);
  ASSERT_TRUE(light);
  EXPECT_TRUE(light->exposure_factors.empty());
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_NEAR(std::log(light->light_factors[k]), std::log(f.lamp[k]) - mean, 4.0 * light->sigma[k]) << k;
    EXPECT_LT(light->sigma[k], 1e-3);
    EXPECT_LT(light->sigma[k], both.cameras[0].light->sigma[k]);
  }
  // a camera whose third exposure was 1 % longer
  std::vector<double> lamp = f.lamp;
  lamp[2] *= 1.01;
  std::swap(lamp, f.lamp);
  both.cameras[1] = photometry_of(f, s, {drawn_fringes(f, s, random)});
  const std::optional<LightOfImages> differing = light_of_images(both);
  ASSERT_TRUE(differing);
  ASSERT_EQ(differing->exposure_factors.size(), 2u);
  EXPECT_TRUE(differing->exposure_factors[0].empty());
  EXPECT_NEAR(differing->exposure_factors[1].at(2), std::pow(1.01, 0.9), 3e-3);
  EXPECT_EQ(differing->light_factors, both.cameras[0].light->factor);
}

// A level that nothing tells is no level that is known exactly.
TEST(Photometry, LightThatNothingTellsHasNoStandardError) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  CameraPhotometry camera;
  camera.light = measure::LightFactors{.factor = {0.98, 1.02, 1.05, 1.0},
                                       .sigma = {1e-3, 1e-3, kUnknown, 0.0}};  // the last one is Gray code
  const std::optional<LightOfImages> light = light_of_images({.cameras = {camera, camera}, .warnings = {}});
  ASSERT_TRUE(light);
  EXPECT_NEAR(light->light_factors[0], 0.98, 1e-12);
  EXPECT_NEAR(light->sigma[0], 1e-3 / std::sqrt(2.0), 1e-12);
  EXPECT_EQ(light->light_factors[2], 1.0);
  EXPECT_EQ(light->sigma[2], kUnknown);
  EXPECT_EQ(light->light_factors[3], 1.0);
  EXPECT_EQ(light->sigma[3], 0.0);
}

// Of a twin that states none the black level is unknown: a read noise found at level 0 was told as 0 with a
// sigma of a tenth of the truth.
TEST(Photometry, WithoutABlackLevelThereIsNoReadNoise) {
  const TrueSensor s{.electrons_per_dn = 18.0, .read_noise_dn = 1.3, .black_dn = 31.0, .bits = 10};
  TrueFringes f;
  f.amplitude_dn = 280.0;
  std::mt19937_64 random(18);
  CameraFrames frames;
  frames.captures = {drawn_fringes(f, s, random)};
  frames.flat.assign(2, ImageF(kDrawnWidth, kDrawnHeight));
  for (GrayImage& image : frames.flat)
    for (float& value : image.as_floats()) value = expose(300.0, s, random);
  Twin unstated = photometry_twin(f, s);
  unstated.cameras[0].sensor.black_level_dn = 0.0;
  const Photometry none = analyse_photometry(unstated, {frames});
  ASSERT_TRUE(none.cameras[0].transfer && none.cameras[0].flat);
  const PhotonTransfer& t = *none.cameras[0].transfer;
  EXPECT_NEAR(t.electrons_per_dn.value, 18.0, 4.0 * t.electrons_per_dn.sigma);  // a slope: no level enters
  EXPECT_TRUE(std::isnan(t.read_noise_dn.value));
  EXPECT_TRUE(std::isnan(t.read_noise_electrons.value));
  EXPECT_FALSE(none.cameras[0].sensor.read_noise_dn);
  EXPECT_THAT(none.warnings, Contains(AllOf(HasSubstr("the read noise"), HasSubstr("vignetting and prnu"),
                                            HasSubstr("give --dark"))));

  const auto read_noise = [&](const Twin& twin) {
    const Photometry p = analyse_photometry(twin, {frames});
    EXPECT_THAT(p.warnings, Not(Contains(HasSubstr("the read noise"))));
    return p.cameras.at(0).transfer.value().read_noise_dn;
  };
  Twin of_zero = unstated;  // a level that is wrong, but said
  of_zero.cameras[0].sensor.black_level_is_stated = true;
  EXPECT_TRUE(std::isfinite(read_noise(of_zero).value));
  const Estimate stated = read_noise(photometry_twin(f, s));
  EXPECT_NEAR(stated.value, 1.3, 4.0 * stated.sigma);
  EXPECT_LT(stated.sigma, 0.2);
  frames.dark.assign(4, ImageF(kDrawnWidth, kDrawnHeight));
  for (GrayImage& image : frames.dark)
    for (float& value : image.as_floats()) value = expose(0.0, s, random);
  const Estimate measured = read_noise(unstated);
  EXPECT_NEAR(measured.value, 1.3, 4.0 * measured.sigma);
}

// With a black level b that is taken for 0, a light of 1 + e looks like one of 1 + e L / (L + b).
TEST(Photometry, WithoutABlackLevelFactorsOfTheLightAreDoubted) {
  const TrueSensor s{.black_dn = 31.0};
  TrueFringes f;
  f.steps = 5;
  f.pitches_px = {16.0, 4.0};
  f.lamp = {0.98, 0.99, 1.0, 1.01, 1.02, 1.02, 0.98, 1.01, 0.99, 1.0};
  std::mt19937_64 random(19);
  const CameraFrames frames{.captures = {drawn_fringes(f, s, random)}, .series = {}, .dark = {}, .flat = {}};
  Twin unstated = photometry_twin(f, s);
  const auto told = [&](const Twin& twin) { return analyse_photometry(twin, {frames}).warnings; };
  EXPECT_THAT(told(unstated), Not(Contains(HasSubstr("light_factors"))));
  unstated.cameras[0].sensor.black_level_dn = 0.0;
  EXPECT_THAT(told(unstated),
              Contains(AllOf(HasSubstr("light_factors and exposure_factors"), HasSubstr("give --dark"))));
}

TEST(Photometry, RefusesInOneSentence) {
  const TrueSensor s;
  TrueFringes f;
  f.steps = 4;
  std::mt19937_64 random(15);
  const auto sentence = [&](const CameraFrames& frames) -> std::string {
    try {
      const Photometry p = analyse_photometry(photometry_twin(f, s), {frames});
      return p.warnings.empty() ? "" : p.warnings.front();
    } catch (const std::exception& e) {
      return e.what();
    }
  };
  CameraFrames black;
  black.captures = {drawn_fringes(f, s, random)};
  for (GrayImage& image : black.captures[0].images) std::ranges::fill(image.as_floats(), 0.0f);
  EXPECT_THAT(sentence(black), HasSubstr("nothing can be told from these images"));
  CameraFrames averaged;  // no noise: rounded expectations
  averaged.captures = {drawn_fringes(f, {1e6, 0.0, 12.0, 8}, random)};
  EXPECT_THAT(sentence(averaged), HasSubstr("simulated without shot noise?"));
  CameraFrames radiance;
  radiance.captures = {drawn_fringes(f, s, random)};
  radiance.captures[0].radiance = true;
  EXPECT_THAT(sentence(radiance), HasSubstr("irradiance (EXR)"));
  CameraFrames clipped;
  clipped.captures = {drawn_fringes(f, s, random)};
  clipped.dark.assign(2, ImageF(kDrawnWidth, kDrawnHeight));
  EXPECT_THAT(sentence(clipped), HasSubstr("100 % of the dark values are 0"));
}

}  // namespace
}  // namespace fringetwin::calib::photometry_test
