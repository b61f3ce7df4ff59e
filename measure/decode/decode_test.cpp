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
#include "measure/decode/decode.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/measure/synthetic_fringes.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::decode_test {
namespace {

using testing::decode_errors;
using testing::DecodeErrors;
using testing::FringeScene;
using testing::gray_fringes;
using testing::one_direction;
using testing::project;
using testing::projector_of_width;
using testing::ramp;

constexpr double kTwoPi = 2.0 * std::numbers::pi;

void expect_exact(const Fringes& f, double width_px, double margin_px, const char* what) {
  FringeScene scene;
  scene.quantised = false;
  scene.column_px = ramp(400, 5, -0.5 + margin_px, width_px - 0.5 - margin_px, 3.0);
  const CameraDecode d = decode(project(f, scene), f, projector_of_width(width_px));
  const DecodeErrors e = decode_errors(d.directions[0], scene.column_px);
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

// The code at 0.4 of the steps' exposure: its brightest value, 84 DN, is below the steps' mean of 110 DN.
TEST(Decode, GrayImagesOfAnotherExposureAreReadByTheirOwnLevel) {
  const Fringes f = gray_fringes(4, 20, 0.0, {6, false, true, 0.0, GrayCode::Threshold::mean});
  FringeScene scene;
  scene.column_px = ramp(500, 6, 2.0, 1270.0);
  CameraImages images = project(f, scene);
  const std::vector<PatternSpec> patterns = expand_sequence(f);
  for (std::size_t k = 0; k < patterns.size(); ++k)
    if (patterns[k].is_gray())
      for (float& v : images.images[k].as_floats()) v = std::round(0.4f * v);
  images.gray_code_exposure = 0.4;
  const CameraDecode d = decode(images, f, projector_of_width(1280));
  const DecodeErrors e = decode_errors(d.directions[0], scene.column_px);
  EXPECT_EQ(e.n_valid, scene.column_px.size());
  EXPECT_EQ(e.n_wrong, 0u);
}

TEST(Decode, GrayCodeOnlyGivesTheCentreOfTheWord) {
  // kamino: OpenCV's GrayCodePattern, word k = projector pixel k, so the words begin at -0.5.
  for (const bool lsb_first : {false, true}) {
    Fringes f = gray_fringes(0, 1, -0.5, {10, lsb_first, false, 0.0, GrayCode::Threshold::inverse});
    f.directions.push_back(f.directions[0]);
    f.directions[1].axis = Axis::y;
    FringeScene scene;
    scene.footprint_px = 0.2;
    scene.column_px = ramp(1024, 8, 0.0, 1023.0);
    scene.row_px = ImageD(1024, 8);
    for (std::size_t i = 0; i < scene.row_px.size(); ++i) scene.row_px.data[i] = static_cast<double>(i % 768);
    DecodeOptions o = projector_of_width(1024);
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

// With the complementary bit a word is half a period: its centre is known to within 4/sqrt(12) of 4 px.
TEST(Decode, GrayCodeOnlyWithAComplementaryBitGivesTheCentreOfHalfAPeriod) {
  const Fringes f = gray_fringes(0, 8, 0.0, {5, false, true, 0.0, GrayCode::Threshold::inverse});
  FringeScene scene;
  scene.column_px = ramp(64, 4, 2.0, 254.0);
  const CameraDecode d = decode(project(f, scene), f, projector_of_width(256));
  for (std::size_t i = 0; i < scene.column_px.size(); ++i)
    ASSERT_NEAR(d.directions[0].coordinate_px.data[i], scene.column_px.data[i], 1e-9);
  const double sigma_px = 4.0 / std::sqrt(12.0);
  EXPECT_NEAR(static_cast<double>(d.directions[0].coordinate_sigma_px(3, 3)), sigma_px, 1e-6);
  EXPECT_NEAR(static_cast<double>(d.directions[0].sigma_rad(3, 3)), kTwoPi / 8.0 * sigma_px, 1e-6);
}

TEST(Decode, GrayCodeOnlyMarksDarkPixelsAndUncertainBits) {
  const Fringes f = gray_fringes(0, 8, 0.0, {5, false, false, 0.0, GrayCode::Threshold::white_black});
  FringeScene scene;
  scene.column_px = ramp(256, 4, 0.0, 255.0);
  scene.albedo = ImageF(256, 4, 1.0f);
  scene.albedo(7, 1) = 0.04f;    // amplitude 4 DN
  scene.column_px(9, 2) = 64.0;  // an edge halves the pixel
  const CameraDecode d = decode(project(f, scene), f, projector_of_width(256));
  EXPECT_EQ(d.flags(7, 1), kLowModulation);
  EXPECT_EQ(d.flags(9, 2), kOrderInvalid);
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(7, 1)));
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(9, 2)));
  EXPECT_EQ(d.flags(20, 3), kValid);
}

TEST(Decode, SaturatedPixelsAreMasked) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  FringeScene scene;
  scene.column_px = ramp(300, 4, 0.0, 1279.0);
  CameraImages images = project(f, scene);
  images.images[5].writable(10, 1) = 255.0f;  // one step of one pitch is enough
  images.images[5].writable(11, 1) = 254.0f;
  const CameraDecode d = decode(images, f, projector_of_width(1280));
  EXPECT_EQ(d.flags(10, 1), kSaturated);
  EXPECT_TRUE(std::isnan(d.directions[0].wrapped_rad[1](10, 1)));
  EXPECT_TRUE(std::isfinite(d.directions[0].wrapped_rad[0](10, 1)));
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(10, 1)));
  EXPECT_NE(d.flags(11, 1) & kSaturated, kSaturated);

  DecodeOptions o = projector_of_width(1280);
  o.use_steps = {0, 2, 3};  // without the step that saturates
  EXPECT_EQ(decode(images, f, o).flags(10, 1) & kSaturated, 0);
}

TEST(Decode, TwelveBitSaturation) {
  const Fringes f = one_direction(Unwrap::none, 4, {13}, {0});
  FringeScene scene;
  scene.column_px = ramp(64, 2, 0.0, 63.0);
  CameraImages images = project(f, scene);
  images.bit_depth = 12;
  images.images[0].writable(1, 0) = 255.0f;
  images.images[0].writable(2, 0) = 4095.0f;
  const CameraDecode d = decode(images, f, {});
  EXPECT_EQ(d.flags(1, 0), kValid);
  EXPECT_EQ(d.flags(2, 0), kSaturated);
}

TEST(Decode, LowModulationIsMaskedAtTheThreshold) {
  const Fringes f = one_direction(Unwrap::hierarchical, 4, {400, 20}, {0, 0});
  FringeScene scene;
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
  FringeScene scene;
  scene.quantised = false;
  scene.black_dn = 0.0;
  scene.white_dn = 3e-4;  // far below any DN
  scene.column_px = ramp(300, 4, 0.0, 399.0);
  scene.albedo = ImageF(300, 4, 1.0f);
  scene.albedo(4, 1) = 0.0f;
  scene.albedo(5, 1) = 5e-4f;
  scene.albedo(6, 1) = 2e-3f;
  const CameraDecode d = decode(project(f, scene), f, projector_of_width(400));
  EXPECT_EQ(d.flags(4, 1), kLowModulation);
  EXPECT_EQ(d.flags(5, 1), kLowModulation);
  EXPECT_EQ(d.flags(6, 1), kValid);
  EXPECT_TRUE(d.radiance);
  EXPECT_EQ(decode_errors(d.directions[0], scene.column_px).n_wrong, 0u);
}

TEST(Decode, NotANumberInARadianceImageIsInvalid) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  FringeScene scene;
  scene.quantised = false;
  scene.column_px = ramp(100, 4, 0.0, 1279.0);
  CameraImages images = project(f, scene);
  images.images[2].writable(7, 1) = std::numeric_limits<float>::quiet_NaN();
  const CameraDecode d = decode(images, f, projector_of_width(1280));
  EXPECT_NE(d.flags(7, 1), kValid);
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(7, 1)));
  EXPECT_EQ(d.flags(8, 1), kValid);
}

TEST(Decode, OutsideTheProjectorIsInvalid) {
  // Coordinates beyond the border can be decoded as long as the code reaches there; they are no light
  // of this projector.
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  FringeScene scene;
  scene.quantised = false;
  scene.column_px = ramp(200, 2, -4.0, 1283.0);
  const CameraDecode d = decode(project(f, scene), f, projector_of_width(1280));
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
  FringeScene scene;
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
  FringeScene scene;
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
  EXPECT_NE(refusal(good, f, projector_of_width(1920), ExitCode::usage).find("1365"), std::string::npos);

  const Fringes wb = gray_fringes(4, 20, 0, {4, false, false, 0.0, GrayCode::Threshold::white_black});
  images = project(wb, scene);
  images.white.reset();
  EXPECT_NE(refusal(images, wb, {}, ExitCode::input).find("white"), std::string::npos);
}

}  // namespace
}  // namespace fringetwin::measure::decode_test
