// SPDX-License-Identifier: Apache-2.0
// Response and blur of the projector, from drawn images and from harmonics of closed forms.
//
// | check          | tolerance        | origin                             |
// |----------------|------------------|------------------------------------|
// | gamma, blur    | 4 sigma, at most | its own sigma                      |
// |                | 0.01 and 0.03 px |                                    |
// | response curve | 0.004            | closed form; 8 steps show 4 orders |
#include "calib/photometry/projector_response.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/calib/drawn_photometry.hpp"

namespace fringetwin::calib::projector_response_test {
namespace {

using namespace testing;
using ::testing::HasSubstr;

TEST(ProjectorResponse, GammaAndBlur) {
  std::mt19937_64 random(12);
  const TrueSensor s;
  for (const double gamma : {1.0, 2.2}) {
    TrueFringes f;
    f.gamma = gamma;
    f.blur_px = 0.35;
    f.steps = 8;
    f.amplitude_dn = 100.0;
    const CameraPhotometry c = photometry_of(f, s, {drawn_fringes(f, s, random)});
    ASSERT_EQ(c.directions.size(), 1u);
    const ProjectorPhotometry& p = c.directions[0];
    EXPECT_NEAR(p.gamma.value, gamma, std::max(0.003, std::min(0.01, 4.0 * p.gamma.sigma)));
    EXPECT_NEAR(p.blur_px.value, 0.35, std::min(0.03, 4.0 * p.blur_px.sigma));
    EXPECT_LT(p.gamma_misfit, 0.003);
    EXPECT_LT(p.blur_misfit, 0.05);
    EXPECT_EQ(p.response.kind,
              gamma == 1.0 ? ProjectorResponse::Kind::linear : ProjectorResponse::Kind::gamma);
    for (std::size_t i = 0; i < p.curve_level.size(); ++i)
      EXPECT_NEAR(p.curve_light[i], std::pow(p.curve_level[i], gamma), 0.004) << p.curve_level[i];
  }
}

TEST(ProjectorResponse, FourStepsKnowOneHarmonicThreeNone) {
  std::mt19937_64 random(13);
  const TrueSensor s;
  TrueFringes f;
  f.gamma = 1.8;
  f.steps = 4;
  const CameraPhotometry four = photometry_of(f, s, {drawn_fringes(f, s, random)});
  EXPECT_NEAR(four.directions[0].gamma.value, 1.8, 0.02);
  EXPECT_TRUE(four.directions[0].curve_light.empty());
  f.steps = 3;
  CameraFrames frames;
  frames.captures = {drawn_fringes(f, s, random)};
  const Photometry three = analyse_photometry(photometry_twin(f, s), {frames});
  EXPECT_FALSE(three.cameras[0].transfer);
  EXPECT_THAT(three.warnings.at(0), HasSubstr("needs repeated captures or series, or 4 phase steps"));
  EXPECT_FALSE(three.cameras[0].directions[0].response_known);
  EXPECT_GT(three.cameras[0].directions[0].mtf.size(), 1u);
}

// The camera lowers the finer fringes, too: to 0.7, of the coarse ones to 0.95. What is left is the
// projector's blur of 1.5 px, exp(-2 pi^2 1.5^2 (1/16^2 - 1/64^2)).
TEST(ProjectorResponse, TheCamerasContrastIsNotCalledBlur) {
  const double blur =
      std::exp(-2.0 * std::numbers::pi * std::numbers::pi * 2.25 * (1.0 / 256.0 - 1.0 / 4096.0));
  const auto pitch = [](double pitch_px, double amplitude, double camera) {
    PitchHarmonics out;
    out.pitch_px = pitch_px;
    out.amplitude = {{amplitude, 1e-4}};
    out.quadrature = {{0.0, 1e-4}};
    out.median_dn = {60.0 * amplitude};
    out.camera_factor = {camera};
    return out;
  };
  FringeHarmonics h;
  h.steps = 3;
  h.n = 100000;
  h.reference = 0;
  h.pitches = {pitch(64.0, 1.0, 0.95), pitch(16.0, blur * 0.7 / 0.95, 0.7)};
  const ProjectorPhotometry p = projector_photometry(h, 0.5, 0.5);
  ASSERT_EQ(p.mtf.size(), 1u);
  EXPECT_NEAR(p.mtf[0].camera_factor, 0.7 / 0.95, 1e-12);
  EXPECT_EQ(p.mtf[0].period_px, 16.0);
  EXPECT_NEAR(p.blur_px.value, 1.5, 1e-9);
}

// A response that is no power: an s-curve comes back as a table.
TEST(ProjectorResponse, TableWhereNoGammaFits) {
  FringeHarmonics h;
  h.steps = 12;
  h.n = 100000;
  PitchHarmonics pitch;
  pitch.pitch_px = 64.0;
  const auto curve = [](double v) { return v * v * (3.0 - 2.0 * v); };
  std::vector<double> orders(7, 0.0);
  for (int i = 0; i < 4096; ++i) {
    const double t = 2.0 * std::numbers::pi * i / 4096.0;
    for (std::size_t k = 0; k < orders.size(); ++k)
      orders[k] += 2.0 / 4096.0 * curve(0.5 + 0.5 * std::cos(t)) * std::cos(static_cast<double>(k) * t);
  }
  for (std::size_t k = 1; k < orders.size(); ++k) {
    pitch.amplitude.push_back({orders[k] / orders[1], 1e-4});
    pitch.quadrature.push_back({0.0, 1e-4});
    pitch.median_dn.push_back(60.0 * std::abs(orders[k] / orders[1]));
    pitch.camera_factor.push_back(1.0);
  }
  h.pitches = {pitch};
  const ProjectorPhotometry p = projector_photometry(h, 0.5, 0.5);
  EXPECT_GT(p.gamma_misfit, 0.01);
  ASSERT_EQ(p.response.kind, ProjectorResponse::Kind::table);
  for (double v = 0.0; v <= 1.0; v += 0.01) EXPECT_NEAR(p.response(v), curve(v), 1e-3) << v;
  EXPECT_FALSE(std::isfinite(p.blur_px.value));  // one pitch
}

// Neither 0.35 +- 0.2 px where the twin has none is worth writing down, nor 0 +- 0.3 where it has 0.2; a blur
// that it lacks, or has and should not, is.
TEST(ProjectorResponse, BlurToldFromNoneOrFromTheTwins) {
  ProjectorPhotometry p;
  const auto tells = [&](double value, double sigma, double of_twin) {
    p.blur_px = {value, sigma}, p.blur_of_twin_px = of_twin;
    return p.tells_blur();
  };
  EXPECT_FALSE(tells(0.35, 0.2, 0.0));
  EXPECT_TRUE(tells(0.35, 0.03, 0.0));
  EXPECT_TRUE(tells(1.52, 0.02, 1.5));
  EXPECT_TRUE(tells(0.03, 0.05, 1.5));
  EXPECT_FALSE(tells(0.0, 0.3, 0.2));
}

}  // namespace
}  // namespace fringetwin::calib::projector_response_test
