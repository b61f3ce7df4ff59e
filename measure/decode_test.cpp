// SPDX-License-Identifier: Apache-2.0
// Images formed in double precision from pattern_value() -> decode() -> the coordinate put in.
// | check                                | tolerance | unit | origin |
// |--------------------------------------|-----------|------|----------------------------------------------------|
// | radiance images, no noise            | 2e-6      | rad  | float images (2^-24 mean/amplitude) and float
// atan2 | | 8 bit, no noise: rms error           | 1.2       | predicted sigma | 1/sqrt(12) DN of
// quantisation, not quite white | | noise: error / predicted sigma, rms  | 10        | %    | noise estimated
// from residuals: 3 % per bin        | | estimated gray-value noise           | 5         | %    | > 1000
// samples in a bin                            | | wrong orders at the stated noise     | 0         | -    |
// after repair, no noise beyond the tolerance        |
#include "measure/decode.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>

#include "measure/synthetic_fringes.hpp"
#include "twin/errors.hpp"
#include "twin/property_testing.hpp"

namespace fringetwin::measure {
namespace {

using synthetic::compare;
using synthetic::Errors;
using synthetic::one_direction;
using synthetic::project;
using synthetic::ramp;
using synthetic::Scene;

constexpr double kTwoPi = 2.0 * std::numbers::pi;

Fringes gray_fringes(int steps, double pitch, double origin, GrayCode code) {
  Fringes f = one_direction(Unwrap::gray, steps, {pitch}, {origin});
  f.directions[0].gray = code;
  return f;
}

DecodeOptions projector(double width_px) {
  DecodeOptions o;
  o.projector_width_px = width_px;
  return o;
}

void expect_exact(const Fringes& f, double width_px, double margin_px, const char* what) {
  Scene scene;
  scene.quantised = false;
  scene.column_px = ramp(400, 5, -0.5 + margin_px, width_px - 0.5 - margin_px, 3.0);
  const CameraDecode d = decode(project(f, scene), f, projector(width_px));
  const Errors e = compare(d.directions[0], scene.column_px);
  const double finest = d.directions[0].pitches_px[static_cast<std::size_t>(d.directions[0].finest)];
  EXPECT_EQ(e.n_valid, scene.column_px.size()) << what;
  EXPECT_EQ(e.n_wrong, 0u) << what;
  EXPECT_LT(e.worst_px, finest / kTwoPi * 2e-6 + 1e-12 * width_px) << what;
}

TEST(Decode, EveryUnwrappingIsExactWithoutNoise) {
  for (const int steps : {3, 7}) {
    expect_exact(one_direction(Unwrap::heterodyne, steps, {13, 14, 15}, {0, 0, 0}), 1280, 0.01, "heterodyne");
    expect_exact(one_direction(Unwrap::heterodyne, steps, {15, 13, 14}, {-20, 4.5, 700}), 1280, 0.01,
                 "origins");
    expect_exact(one_direction(Unwrap::hierarchical, steps, {16, 1024, 64, 256}, {8, 512, 32, 128}), 1024,
                 0.01, "hierarchical");
    expect_exact(one_direction(Unwrap::hierarchical, steps, {600}, {-77}), 600, 0.01, "one pitch");
    for (const bool lsb_first : {false, true})
      for (const bool complementary : {false, true})
        for (const double offset : {-0.5, 0.0, 0.25})
          for (const auto threshold :
               {GrayCode::Threshold::mean, GrayCode::Threshold::inverse, GrayCode::Threshold::white_black}) {
            const GrayCode code{6, lsb_first, complementary, offset, threshold};
            expect_exact(gray_fringes(steps, 20, -31.5, code), 1280, 0.7, "gray");
          }
  }
}

TEST(Decode, GrayCodeOnlyGivesTheCentreOfTheWord) {
  // kamino: OpenCV's GrayCodePattern, word k = projector pixel k, so the words begin at -0.5.
  for (const bool lsb_first : {false, true}) {
    Fringes f = gray_fringes(0, 1, -0.5, {10, lsb_first, false, 0.0, GrayCode::Threshold::inverse});
    f.directions.push_back(f.directions[0]);
    f.directions[1].axis = Axis::y;
    Scene scene;
    scene.footprint_px = 0.2;
    scene.column_px = ramp(1024, 8, 0.0, 1023.0);
    scene.row_px = ImageD(1024, 8);
    for (std::size_t i = 0; i < scene.row_px.size(); ++i) scene.row_px.data[i] = static_cast<double>(i % 768);
    DecodeOptions o = projector(1024);
    o.projector_height_px = 768;
    const CameraDecode d = decode(project(f, scene), f, o);
    for (std::size_t i = 0; i < scene.row_px.size(); ++i) {
      ASSERT_EQ(d.directions[0].coordinate_px.data[i], std::round(scene.column_px.data[i]));
      ASSERT_EQ(d.directions[1].coordinate_px.data[i], scene.row_px.data[i]);
      ASSERT_EQ(d.flags.data[i], kValid);
    }
    EXPECT_NEAR(static_cast<double>(d.directions[0].coordinate_sigma_px(3, 3)), 1.0 / std::sqrt(12.0), 1e-6);
    EXPECT_TRUE(d.directions[0].wrapped_rad.empty());
    ASSERT_NE(d.direction(Axis::y), nullptr);
    EXPECT_EQ(d.direction(Axis::y)->axis, Axis::y);
  }
}

TEST(Decode, GrayCodeOnlyMarksDarkPixelsAndUncertainBits) {
  const Fringes f = gray_fringes(0, 8, 0.0, {5, false, false, 0.0, GrayCode::Threshold::white_black});
  Scene scene;
  scene.column_px = ramp(256, 4, 0.0, 255.0);
  scene.albedo = ImageF(256, 4, 1.0f);
  scene.albedo(7, 1) = 0.04f;    // amplitude 4 DN
  scene.column_px(9, 2) = 64.0;  // an edge halves the pixel
  const CameraDecode d = decode(project(f, scene), f, projector(256));
  EXPECT_EQ(d.flags(7, 1), kLowModulation);
  EXPECT_EQ(d.flags(9, 2), kOrderInvalid);
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(7, 1)));
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(9, 2)));
  EXPECT_EQ(d.flags(20, 3), kValid);
}

TEST(Decode, SaturatedPixelsAreMasked) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  Scene scene;
  scene.column_px = ramp(300, 4, 0.0, 1279.0);
  CameraImages images = project(f, scene);
  images.images[5](10, 1) = 255.0f;  // one step of one pitch is enough
  images.images[5](11, 1) = 254.0f;
  const CameraDecode d = decode(images, f, projector(1280));
  EXPECT_EQ(d.flags(10, 1), kSaturated);
  EXPECT_TRUE(std::isnan(d.directions[0].wrapped_rad[1](10, 1)));
  EXPECT_TRUE(std::isfinite(d.directions[0].wrapped_rad[0](10, 1)));
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(10, 1)));
  EXPECT_NE(d.flags(11, 1) & kSaturated, kSaturated);

  DecodeOptions o = projector(1280);
  o.use_steps = {0, 2, 3};  // without the step that saturates
  EXPECT_EQ(decode(images, f, o).flags(10, 1) & kSaturated, 0);
}

TEST(Decode, TwelveBitSaturation) {
  const Fringes f = one_direction(Unwrap::none, 4, {13}, {0});
  Scene scene;
  scene.column_px = ramp(64, 2, 0.0, 63.0);
  CameraImages images = project(f, scene);
  images.bit_depth = 12;
  images.images[0](1, 0) = 255.0f;
  images.images[0](2, 0) = 4095.0f;
  const CameraDecode d = decode(images, f, {});
  EXPECT_EQ(d.flags(1, 0), kValid);
  EXPECT_EQ(d.flags(2, 0), kSaturated);
}

TEST(Decode, LowModulationIsMaskedAtTheThreshold) {
  const Fringes f = one_direction(Unwrap::hierarchical, 4, {400, 20}, {0, 0});
  Scene scene;
  scene.column_px = ramp(101, 3, 0.0, 399.0);
  scene.albedo = ImageF(101, 3);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x <= 100; ++x) scene.albedo(x, y) = 0.01f * static_cast<float>(x);  // amplitude x DN
  const CameraDecode d = decode(project(f, scene), f, {});
  for (int x = 0; x <= 100; ++x) {
    if (x < 4 || x > 6) {
      EXPECT_EQ(d.flags(x, 0), x < 4 ? kLowModulation : kValid) << x;
    }
    EXPECT_EQ(std::isnan(d.directions[0].coordinate_px(x, 0)), d.flags(x, 0) != kValid);
  }
  EXPECT_TRUE(std::isfinite(d.directions[0].amplitude_dn[0](0, 0)));
}

TEST(Decode, RadianceThresholdFollowsTheImages) {
  const Fringes f = one_direction(Unwrap::hierarchical, 4, {400, 20}, {0, 0});
  Scene scene;
  scene.quantised = false;
  scene.black_dn = 0.0;
  scene.white_dn = 3e-4;  // far below any DN
  scene.column_px = ramp(300, 4, 0.0, 399.0);
  scene.albedo = ImageF(300, 4, 1.0f);
  scene.albedo(4, 1) = 0.0f;
  scene.albedo(5, 1) = 5e-4f;
  scene.albedo(6, 1) = 2e-3f;
  const CameraDecode d = decode(project(f, scene), f, projector(400));
  EXPECT_EQ(d.flags(4, 1), kLowModulation);
  EXPECT_EQ(d.flags(5, 1), kLowModulation);
  EXPECT_EQ(d.flags(6, 1), kValid);
  EXPECT_EQ(compare(d.directions[0], scene.column_px).n_wrong, 0u);
}

TEST(Decode, NotANumberInARadianceImageIsInvalid) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  Scene scene;
  scene.quantised = false;
  scene.column_px = ramp(100, 4, 0.0, 1279.0);
  CameraImages images = project(f, scene);
  images.images[2](7, 1) = std::numeric_limits<float>::quiet_NaN();
  const CameraDecode d = decode(images, f, projector(1280));
  EXPECT_NE(d.flags(7, 1), kValid);
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(7, 1)));
  EXPECT_EQ(d.flags(8, 1), kValid);
}

TEST(Decode, OutsideTheProjectorIsInvalid) {
  // Coordinates beyond the border can be decoded as long as the code reaches there; they are no light
  // of this projector.
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  Scene scene;
  scene.quantised = false;
  scene.column_px = ramp(200, 2, -4.0, 1283.0);
  const CameraDecode d = decode(project(f, scene), f, projector(1280));
  for (int x = 0; x < 200; ++x) {
    const double truth = scene.column_px(x, 0);
    const bool inside = truth >= -0.5 && truth < 1279.5;
    EXPECT_EQ(d.flags(x, 0) == kValid, inside) << truth;
    if (!inside) {
      EXPECT_EQ(d.flags(x, 0), kOrderInvalid);
    }
  }
}

TEST(Decode, WithoutUnwrappingTheWrappedPhaseRemains) {
  const Fringes f = one_direction(Unwrap::none, 5, {20, 30}, {3, 4});
  Scene scene;
  scene.quantised = false;
  scene.column_px = ramp(100, 3, -50.0, 50.0);
  const CameraDecode d = decode(project(f, scene), f, {});
  const DirectionDecode& x = d.directions[0];
  EXPECT_FALSE(x.unwrapped);
  for (std::size_t i = 0; i < scene.column_px.size(); ++i) {
    EXPECT_EQ(d.flags.data[i], kValid);
    EXPECT_TRUE(std::isnan(x.coordinate_px.data[i]));
    const double expected = kTwoPi * (scene.column_px.data[i] - 3.0) / 20.0;
    EXPECT_LT(std::fabs(std::remainder(static_cast<double>(x.wrapped_rad[0].data[i]) - expected, kTwoPi)),
              2e-6);
  }
}

// ---- noise and sigma --------------------------------------------------------------------------------

/// rms of error / predicted sigma over the valid pixels.
double normalised_rms(const DirectionDecode& d, const ImageD& truth_px) {
  double sum = 0.0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < truth_px.size(); ++i) {
    if (!std::isfinite(d.coordinate_px.data[i])) continue;
    const double e =
        (d.coordinate_px.data[i] - truth_px.data[i]) / static_cast<double>(d.coordinate_sigma_px.data[i]);
    sum += e * e;
    ++n;
  }
  return std::sqrt(sum / static_cast<double>(n));
}

Scene noisy_scene(double noise_dn) {
  Scene scene;
  scene.noise_dn = noise_dn;
  scene.column_px = ramp(400, 200, 2.0, 1277.0, 40.0);
  scene.albedo = ImageF(400, 200);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 400; ++x) scene.albedo(x, y) = 0.4f + 0.5f * static_cast<float>(y) / 199.0f;
  return scene;
}

TEST(Decode, SigmaPredictsTheErrorForAllModesAndSubsets) {
  const GrayCode code{5, false, true, -0.5, GrayCode::Threshold::mean};
  const Fringes all[] = {one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 1, 2}),
                         one_direction(Unwrap::heterodyne, 8, {13, 14, 15}, {0, 1, 2}),
                         one_direction(Unwrap::hierarchical, 12, {1280, 160, 20}, {640, 80, 10}),
                         gray_fringes(12, 40, 20, code)};
  for (const Fringes& f : all) {
    Scene scene = noisy_scene(1.5);
    const CameraImages images = project(f, scene);
    DecodeOptions o = projector(1280);
    const CameraDecode d = decode(images, f, o);
    EXPECT_EQ(d.directions[0].noise_source, NoiseSource::residuals);
    EXPECT_NEAR(d.directions[0].noise_dn, std::sqrt(1.5 * 1.5 + 1.0 / 12.0), 0.05 * 1.5) << f.steps;
    EXPECT_NEAR(normalised_rms(d.directions[0], scene.column_px), 1.0, 0.1) << f.steps << " steps";
    EXPECT_EQ(compare(d.directions[0], scene.column_px).n_wrong, 0u) << f.steps;
    if (f.steps < 8) continue;
    o.use_steps = {0, 1, 3, 6};  // uneven: sigma depends on the phase
    EXPECT_NEAR(normalised_rms(decode(images, f, o).directions[0], scene.column_px), 1.0, 0.1) << "subset";
    o.use_steps = {0, 2, 4, 6};
    EXPECT_EQ(compare(decode(images, f, o).directions[0], scene.column_px).n_wrong, 0u) << "even steps";
  }
}

TEST(Decode, KnownNoiseIsUsedAsGiven) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  const Scene scene = noisy_scene(2.0);
  DecodeOptions o = projector(1280);
  o.variance_offset_dn2 = 4.0;
  o.variance_per_dn = 0.0;
  const CameraDecode d = decode(project(f, scene), f, o);
  const DirectionDecode& x = d.directions[0];
  EXPECT_EQ(x.noise_source, NoiseSource::known);
  EXPECT_NEAR(x.noise_dn, std::sqrt(4.0 + 1.0 / 12.0), 1e-4);
  const double expected =
      std::sqrt(2.0 / 4.0 * (4.0 + 1.0 / 12.0)) / static_cast<double>(x.amplitude_dn[0](200, 100));
  EXPECT_NEAR(static_cast<double>(x.sigma_rad(200, 100)) / expected, 1.0, 1e-3);
  EXPECT_NEAR(normalised_rms(x, scene.column_px), 1.0, 0.05);
}

TEST(Decode, QuantisationIsTheFloor) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  const Scene scene = noisy_scene(0.0);
  const CameraDecode d = decode(project(f, scene), f, projector(1280));
  EXPECT_GE(d.directions[0].noise_dn, 0.288);
  EXPECT_LT(d.directions[0].noise_dn, 0.35);
  EXPECT_LT(normalised_rms(d.directions[0], scene.column_px), 1.2);
  EXPECT_GT(normalised_rms(d.directions[0], scene.column_px), 0.7);
  const Fringes three = one_direction(Unwrap::heterodyne, 3, {13, 14, 15}, {0, 0, 0});
  EXPECT_EQ(decode(project(three, scene), three, projector(1280)).directions[0].noise_source,
            NoiseSource::quantisation);
}

TEST(Decode, HarmonicsOfTheProjectorAreNotNoise) {
  // A gamma of 2 puts a strong second harmonic into the residuals; its second difference along the
  // stripes is small.
  const Fringes f = one_direction(Unwrap::hierarchical, 8, {1280, 160, 20}, {640, 80, 10});
  Scene scene = noisy_scene(0.0);
  scene.quantised = false;
  scene.column_px = ramp(400, 200, 2.0, 1277.0, 10.0);
  CameraImages images = project(f, scene);
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (ImageF& image : images.images)
    for (float& v : image.data) {
      const double share = static_cast<double>(v) / 210.0;
      v = static_cast<float>(std::round(210.0 * share * share + normal(random)));
    }
  images.radiance = false;
  const CameraDecode d = decode(images, f, projector(1280));
  EXPECT_NEAR(d.directions[0].noise_dn, std::sqrt(1.0 + 1.0 / 12.0), 0.07);
}

// ---- properties -------------------------------------------------------------------------------------

RC_GTEST_PROP(Decode, HeterodyneWithNoiseWithinTheTolerance, ()) {
  const int steps = *rc::gen::inRange(3, 9);
  std::vector<double> origins;
  for (int i = 0; i < 3; ++i) origins.push_back(*testing::uniform(-2000.0, 2000.0));
  const double scale = *testing::uniform(1.0, 3.0);
  const Fringes f = one_direction(Unwrap::heterodyne, steps, {14 * scale, 13 * scale, 15 * scale}, origins);
  const double width = std::floor(1280 * scale);
  Scene scene;
  scene.column_px = ramp(110, 9, 2.0, width - 3.0, 0.01 * width);
  // Phase sigma 0.03 rad or less: sqrt(2/N) noise / 100 DN.
  scene.noise_dn = *testing::uniform(0.0, 3.0) * std::sqrt(steps / 2.0);
  scene.seed = *rc::gen::arbitrary<unsigned>();
  const Errors e = compare(decode(project(f, scene), f, projector(width)).directions[0], scene.column_px);
  RC_ASSERT(e.n_wrong == 0u);
  RC_ASSERT(e.n_valid >= scene.column_px.size() - 5);
}

RC_GTEST_PROP(Decode, GrayCodeOfAnyKindWithNoise, ()) {
  const int steps = *rc::gen::inRange(3, 13), bits = *rc::gen::inRange(3, 7);
  GrayCode code;
  code.bits = bits;
  code.lsb_first = *rc::gen::arbitrary<bool>();
  code.complementary = *rc::gen::arbitrary<bool>();
  code.offset_periods = *testing::uniform(-1.0, 1.0);
  code.threshold = *rc::gen::element(GrayCode::Threshold::mean, GrayCode::Threshold::inverse,
                                     GrayCode::Threshold::white_black);
  const double pitch = *testing::uniform(12.0, 60.0);
  const Fringes f = gray_fringes(steps, pitch, *testing::uniform(-900.0, 900.0), code);
  const double width = std::floor(pitch * std::ldexp(1.0, bits));
  // 12 camera pixels a period: the footprint is a camera pixel.
  const int w = 12 << bits;
  Scene scene;
  scene.column_px = ramp(w, 8, 0.0, width - 1.0, 0.3 * pitch);
  scene.footprint_px = pitch / 12.0;
  scene.noise_dn = *testing::uniform(0.0, 2.0) * std::sqrt(steps / 2.0);  // phase sigma up to 0.02 rad
  scene.seed = *rc::gen::arbitrary<unsigned>();
  const DirectionDecode d = decode(project(f, scene), f, projector(width)).directions[0];
  const Errors e = compare(d, scene.column_px);
  RC_ASSERT(e.n_wrong == 0u);
  RC_ASSERT(d.repair.n_left == 0u);
  RC_ASSERT(e.n_valid >= scene.column_px.size() * 98 / 100);  // the borders of the projector
}

TEST(Decode, ErrorsOfHardCodeEdgesAreRepairedAndCounted) {
  // Edges sharper than a pixel and phase noise: some orders are wrong before the repair.
  const Fringes f = gray_fringes(4, 40, 0, {5, false, false, 0.0, GrayCode::Threshold::mean});
  Scene scene = noisy_scene(4.0);
  scene.footprint_px = 0.0;
  const CameraImages images = project(f, scene);
  DecodeOptions o = projector(1280);
  o.repair_orders = false;
  const DirectionDecode raw = decode(images, f, o).directions[0];
  const Errors before = compare(raw, scene.column_px);
  EXPECT_GT(before.n_wrong, 50u);
  EXPECT_GT(raw.repair.n_left, 50u);
  EXPECT_EQ(raw.repair.n_changed, 0u);
  o.repair_orders = true;
  const DirectionDecode mended = decode(images, f, o).directions[0];
  EXPECT_EQ(compare(mended, scene.column_px).n_wrong, 0u);
  EXPECT_EQ(mended.repair.n_changed, before.n_wrong);
  EXPECT_EQ(mended.repair.n_left, 0u);
}

TEST(Decode, OrdersThatNoiseMakesAGuessAreNotCalledValid) {
  // sigma 0.09 ... 0.44 rad, the stages tolerate 0.061: beyond twice that nothing is valid, below it
  // nearly all of what is valid is right.
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  for (const double noise_dn : {8.0, 12.0, 25.0}) {
    const Scene scene = noisy_scene(noise_dn);
    const CameraDecode d = decode(project(f, scene), f, projector(1280));
    const Errors e = compare(d.directions[0], scene.column_px);
    std::cout << "noise " << noise_dn << " DN: " << e.n_valid << " valid, " << e.n_wrong << " wrong of "
              << scene.column_px.size() << "\n";
    EXPECT_LE(e.n_wrong, e.n_valid / 25) << noise_dn;
    if (noise_dn > 20.0) {
      EXPECT_EQ(e.n_valid, 0u);
    }
  }
}

TEST(Decode, FringesFinerThanThePixelsLoseTheirModulation) {
  // A pixel that covers whole periods sees no modulation; one that covers 0.9 of them little.
  const Fringes f = one_direction(Unwrap::hierarchical, 4, {1280, 160, 16}, {0, 0, 0});
  Scene scene;
  scene.column_px = ramp(200, 4, 20.0, 1200.0);
  CameraImages images = project(f, scene);
  const std::vector<PatternSpec> sequence = expand_sequence(f);
  for (std::size_t i = 0; i < images.images.size(); ++i) {
    if (f.directions[0].pitches_px[static_cast<std::size_t>(sequence[i].pitch)] > 16.0) continue;
    for (std::size_t k = 0; k < scene.column_px.size(); ++k)
      images.images[i].data[k] = static_cast<float>(
          std::round(10.0 + 200.0 * synthetic::bit_average(f, sequence[i], scene.column_px.data[k], 16.0)));
  }
  const CameraDecode d = decode(images, f, projector(1280));
  for (const unsigned char flag : d.flags.data) ASSERT_EQ(flag, kLowModulation);
  for (const double x : d.directions[0].coordinate_px.data) ASSERT_TRUE(std::isnan(x));
  EXPECT_TRUE(std::isfinite(d.directions[0].wrapped_rad[0](100, 2)));
}

// ---- refusals ---------------------------------------------------------------------------------------

std::string refusal(const CameraImages& images, const Fringes& f, const DecodeOptions& o, ExitCode expected) {
  try {
    decode(images, f, o);
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), expected) << e.what();
    return e.what();
  }
  return "";
}

TEST(Decode, RefusesWhatDoesNotFit) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  Scene scene;
  scene.column_px = ramp(20, 2, 0.0, 100.0);
  const CameraImages good = project(f, scene);

  CameraImages images = good;
  images.images.pop_back();
  const std::string count = refusal(images, f, {}, ExitCode::input);
  EXPECT_NE(count.find("11"), std::string::npos) << count;
  EXPECT_NE(count.find("12"), std::string::npos) << count;

  images = good;
  images.images[3] = ImageF(21, 2);
  const std::string size = refusal(images, f, {}, ExitCode::input);
  EXPECT_NE(size.find("image 3"), std::string::npos) << size;

  DecodeOptions o;
  o.use_steps = {0, 1};
  EXPECT_NE(refusal(good, f, o, ExitCode::usage), "");
  o.use_steps = {0, 1, 4};
  EXPECT_NE(refusal(good, f, o, ExitCode::usage), "");
  EXPECT_NE(refusal(good, f, projector(1920), ExitCode::usage).find("1365"), std::string::npos);

  const Fringes wb = gray_fringes(4, 20, 0, {4, false, false, 0.0, GrayCode::Threshold::white_black});
  images = project(wb, scene);
  images.white.reset();
  EXPECT_NE(refusal(images, wb, {}, ExitCode::input).find("white"), std::string::npos);
}

TEST(Decode, ThePapersTwentyFourImagesInTime) {
  // 2 cameras x 12 images of 1440 x 1080; the goal is 0.4 s on 2 free cores, the test only notices
  // gross errors because other programs may be running.
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  Scene scene = noisy_scene(0.5);
  scene.column_px = ramp(1440, 1080, 2.0, 1277.0, 30.0);
  scene.albedo = {};
  const CameraImages images = project(f, scene);
  double best_s = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const auto start = std::chrono::steady_clock::now();
    for (int camera = 0; camera < 2; ++camera) decode(images, f, projector(1280));
    best_s =
        std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::cout << "decoding 24 images of 1440 x 1080: " << best_s << " s (best of 3)\n";
  EXPECT_LT(best_s, 4.0);
}

}  // namespace
}  // namespace fringetwin::measure
