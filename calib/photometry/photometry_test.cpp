// SPDX-License-Identifier: Apache-2.0
// Photometry of drawn images whose sensor, projector and lens are known. The images are made here from the
// closed forms, with the standard library's distributions: nothing of the renderer.
//
// | check                                  | tolerance           | origin                                   |
// |----------------------------------------|---------------------|------------------------------------------|
// | gain, read noise of each draw          | 4 sigma             | its own sigma                            |
// | scatter over 12 draws / printed sigma  | 0.5 ... 1.5         | a scatter of 12 is known to 20 %         |
// | mean error over 5 and 10 draws         | 4 standard errors   | its own sigma over the root of the draws |
// | gain with edges, harmonics, flicker    | 4 sigma; 2 % from   | its own sigma; issue: 3 %                |
// |                                        | repeats             |                                          |
// | gamma, blur                            | 4 sigma, at most    | its own sigma                            |
// |                                        | 0.01 and 0.03 px    |                                          |
// | response curve                         | 0.004               | closed form; 8 steps show 4 orders       |
// | vignetting over the image              | 0.005               | 4 times a cell mean's noise of 1.2e-3    |
// | light of the images                    | 4 sigma             | its own sigma                            |
// | levels of exposures                    | 0.1 %               | drawn                                    |
#include "calib/photometry/photometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace fringetwin::calib::photometry_test {
namespace {

using ::testing::HasSubstr;

struct TrueSensor {
  double electrons_per_dn = 40.0, read_noise_dn = 0.9, black_dn = 12.0;
  int bits = 8;
  bool poisson = false;  ///< else normal with the same variance: a quarter of the time
};

/// One gray value for an expected signal (DN above black).
float expose(double signal_dn, const TrueSensor& s, std::mt19937_64& random) {
  double dn = s.black_dn;
  double variance = s.read_noise_dn * s.read_noise_dn;
  if (s.poisson) {
    std::poisson_distribution<int> electrons(std::max(1e-9, signal_dn * s.electrons_per_dn));
    dn += electrons(random) / s.electrons_per_dn;
  } else {
    dn += signal_dn;
    variance += signal_dn / s.electrons_per_dn;
  }
  thread_local std::normal_distribution<double> normal;
  dn += std::sqrt(variance) * normal(random);
  return static_cast<float>(std::clamp(std::round(dn), 0.0, std::pow(2.0, s.bits) - 1.0));
}

struct TrueFringes {
  double gamma = 1.0, blur_px = 0.0, amplitude_dn = 80.0, brightest = 1.0;
  std::vector<double> pitches_px{64.0, 16.0, 4.0};
  int steps = 6;
  bool edges = false;
  double lean_px = 0.0;  ///< of the stripes, per row
  double flicker = 0.0;
  std::vector<double> lamp = {};  ///< of each image, instead of a flicker at random
};

constexpr int kWidth = 320, kHeight = 200;
constexpr double kPxPerColumn = 0.11;  // projector px per camera column

/// Light of the projector at x for step n: series of the response, each order lowered by the blur.
double light(const TrueFringes& f, double pitch, int n, double x, const std::vector<double>& orders) {
  const double theta = 2.0 * std::numbers::pi * (x / pitch + static_cast<double>(n) / f.steps);
  double sum = orders[0];
  for (std::size_t h = 1; h < orders.size(); ++h) {
    const double k = 2.0 * std::numbers::pi * static_cast<double>(h) / pitch;
    const double half = 0.5 * k * kPxPerColumn;  // the camera pixel's box
    sum += orders[h] * std::exp(-0.5 * k * k * f.blur_px * f.blur_px) * std::sin(half) / half *
           std::cos(static_cast<double>(h) * theta);
  }
  return sum;
}

/// Fourier series of ((1 + cos)/2)^gamma by a sum over the circle.
std::vector<double> response_orders(double gamma) {
  std::vector<double> out(12, 0.0);
  for (int i = 0; i < 4096; ++i) {
    const double t = 2.0 * std::numbers::pi * i / 4096.0;
    const double v = std::pow(0.5 + 0.5 * std::cos(t), gamma);
    for (std::size_t h = 0; h < out.size(); ++h)
      out[h] += (h == 0 ? 1.0 : 2.0) / 4096.0 * v * std::cos(static_cast<double>(h) * t);
  }
  return out;
}

Twin small_twin(const TrueFringes& f, const TrueSensor& s) {
  Twin twin;
  twin.cameras.push_back({"left",
                          Lens("LENSMODEL_PINHOLE", {400, 400, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)},
                               {kWidth, kHeight}, "test"),
                          Pose{}, Sensor{}, std::nullopt});
  twin.cameras[0].sensor.bit_depth = s.bits;
  twin.cameras[0].sensor.black_level_dn = s.black_dn;
  twin.fringes.steps = f.steps;
  twin.fringes.unwrap = Unwrap::none;
  DirectionFringes d;
  d.pitches_px = f.pitches_px;
  d.phase_origin_px.assign(f.pitches_px.size(), 0.0);
  twin.fringes.directions.push_back(d);
  return twin;
}

/// A surface whose brightness varies smoothly, or with edges everywhere.
double albedo(const TrueFringes& f, int x, int y) {
  const double smooth = 0.15 + 0.85 * (0.5 + 0.5 * std::sin(0.015 * x)) * (0.5 + 0.5 * std::cos(0.02 * y));
  if (!f.edges) return smooth;
  return (x / 23 + y / 17) % 2 == 0 ? smooth : 0.35 * smooth;
}

CameraImages draw(const TrueFringes& f, const TrueSensor& s, std::mt19937_64& random) {
  CameraImages out;
  out.camera = "left";
  out.bit_depth = s.bits;
  const auto orders = response_orders(f.gamma);
  std::normal_distribution<double> flicker(1.0, f.flicker);
  ImageD albedo_map(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) albedo_map(x, y) = albedo(f, x, y);
  for (const double pitch : f.pitches_px)
    for (int n = 0; n < f.steps; ++n) {
      ImageF image(kWidth, kHeight);
      const double lamp = !f.lamp.empty()   ? f.lamp.at(out.images.size())
                          : f.flicker > 0.0 ? flicker(random)
                                            : 1.0;
      std::vector<double> row(kWidth);
      for (int y = 0; y < kHeight; ++y) {
        if (y == 0 || f.lean_px > 0.0)
          for (int x = 0; x < kWidth; ++x)
            row[static_cast<std::size_t>(x)] = light(f, pitch, n, kPxPerColumn * x + f.lean_px * y, orders);
        for (int x = 0; x < kWidth; ++x)
          image(x, y) = expose(
              2.0 * f.amplitude_dn * lamp * albedo_map(x, y) * row[static_cast<std::size_t>(x)], s, random);
      }
      out.images.push_back(std::move(image));
    }
  return out;
}

CameraPhotometry measure(const TrueFringes& f, const TrueSensor& s, std::vector<CameraImages> captures) {
  CameraFrames frames;
  frames.captures = std::move(captures);
  return analyse_photometry(small_twin(f, s), {frames}).cameras[0];
}

void expect_sensor(const CameraPhotometry& c, const TrueSensor& s, double largest_sigma) {
  ASSERT_TRUE(c.transfer);
  const PhotonTransfer& t = *c.transfer;
  EXPECT_LT(std::abs(t.dn_per_electron.value - 1.0 / s.electrons_per_dn), 4.0 * t.dn_per_electron.sigma);
  EXPECT_LT(t.dn_per_electron.sigma * s.electrons_per_dn, largest_sigma);
  EXPECT_LT(std::abs(t.read_noise_dn.value - s.read_noise_dn), 4.0 * t.read_noise_dn.sigma);
  EXPECT_LT(t.read_noise_dn.sigma, 0.05 * s.read_noise_dn);
  EXPECT_DOUBLE_EQ(t.read_noise_electrons.value, t.read_noise_dn.value * t.electrons_per_dn.value);
  EXPECT_DOUBLE_EQ(t.read_noise_electrons.sigma, t.read_noise_dn.sigma * t.electrons_per_dn.value);
  EXPECT_LT(std::abs(t.slope_change.value), 4.0 * t.slope_change.sigma);
}

// Sigmas: the scatter over draws is what they promise, from phase steps and from repeats.
TEST(PhotonTransfer, SigmaIsTheScatter) {
  TrueFringes f;
  f.pitches_px = {16.0};
  f.steps = 4;
  const TrueSensor s;
  std::mt19937_64 random(7);
  for (const bool repeats : {false, true}) {
    std::vector<double> gain, gain_sigma, read, read_sigma;
    for (int i = 0; i < 12; ++i) {
      std::vector<CameraImages> captures{draw(f, s, random)};
      if (repeats) captures.push_back(draw(f, s, random));
      const CameraPhotometry c = measure(f, s, captures);
      expect_sensor(c, s, repeats ? 0.03 : 0.15);
      EXPECT_EQ(c.noise_from, repeats ? "repeats" : "phase steps");
      gain.push_back(c.transfer->dn_per_electron.value - 1.0 / s.electrons_per_dn);
      gain_sigma.push_back(c.transfer->dn_per_electron.sigma);
      read.push_back(c.transfer->read_noise_dn.value - s.read_noise_dn);
      read_sigma.push_back(c.transfer->read_noise_dn.sigma);
    }
    const auto relative = [](const std::vector<double>& off, const std::vector<double>& sigma) {
      double sum = 0.0;
      for (std::size_t i = 0; i < off.size(); ++i) sum += std::pow(off[i] / sigma[i], 2);
      return std::sqrt(sum / static_cast<double>(off.size()));
    };
    for (const double r : {relative(gain, gain_sigma), relative(read, read_sigma)}) {
      EXPECT_GT(r, 0.5);
      EXPECT_LT(r, 1.5);
    }
  }
}

/// Expects the sums of the errors of some draws, each over its own sigma, within 4 of their standard errors.
void expect_no_bias(const TrueFringes& f, int draws, std::mt19937_64& random) {
  const TrueSensor s;
  double gain = 0.0, read = 0.0;
  for (int i = 0; i < draws; ++i) {
    const CameraPhotometry c = measure(f, s, {draw(f, s, random)});
    ASSERT_TRUE(c.transfer);
    const Estimate& electrons = c.transfer->electrons_per_dn;
    gain += (electrons.value - s.electrons_per_dn) / electrons.sigma;
    read += (c.transfer->read_noise_dn.value - s.read_noise_dn) / c.transfer->read_noise_dn.sigma;
  }
  EXPECT_LT(std::abs(gain), 4.0 * std::sqrt(draws)) << f.steps;
  EXPECT_LT(std::abs(read), 4.0 * std::sqrt(draws)) << f.steps;
}

// The light of a projector's gamma is no sinusoid: a level taken from one bends the line, and its dark end,
// the read noise, comes out too high by 2 to 3 sigmas in every draw.
TEST(PhotonTransfer, AProjectorsGammaBendsNoLine) {
  TrueFringes f;
  f.gamma = 1.9;
  f.pitches_px = {16.0};
  std::mt19937_64 random(14);
  for (const int steps : {7, 8, 12}) {
    f.steps = steps;
    expect_no_bias(f, 10, random);
  }
}

// Stripes that turn by 0.16 rad per pixel along them: the harmonics are not smooth there.
TEST(PhotonTransfer, HarmonicsOfLeaningStripesAreNoNoise) {
  TrueFringes f;
  f.gamma = 1.9;
  f.pitches_px = {4.0};
  f.steps = 8;
  f.lean_px = 0.1;
  std::mt19937_64 random(15);
  expect_no_bias(f, 5, random);
}

// Edges of the scene, a projector of gamma 2.2 and a flickering lamp are no noise.
TEST(PhotonTransfer, TheSceneIsNoNoise) {
  TrueFringes f;
  f.gamma = 2.2;
  f.edges = true;
  f.lean_px = 0.01;
  f.flicker = 0.01;
  f.steps = 4;
  const TrueSensor s;
  std::mt19937_64 random(8);
  for (const bool repeats : {false, true}) {
    std::vector<CameraImages> captures{draw(f, s, random)};
    if (repeats) captures.push_back(draw(f, s, random));
    const CameraPhotometry c = measure(f, s, captures);
    ASSERT_TRUE(c.transfer);
    const PhotonTransfer& t = *c.transfer;
    EXPECT_LT(std::abs(t.dn_per_electron.value - 1.0 / s.electrons_per_dn), 4.0 * t.dn_per_electron.sigma);
    EXPECT_NEAR(t.dn_per_electron.value * s.electrons_per_dn, 1.0, repeats ? 0.02 : 0.15);
    EXPECT_NEAR(t.read_noise_dn.value, s.read_noise_dn, 0.05);
    if (repeats) {
      EXPECT_NEAR(c.flicker, 0.01 / std::sqrt(2.0), 0.005);
    }
  }
}

TEST(PhotonTransfer, TwelveBitsAndDarkImages) {
  TrueFringes f;
  f.amplitude_dn = 900.0;
  f.pitches_px = {16.0};
  const TrueSensor s{3.0, 4.0, 64.0, 12, true};
  std::mt19937_64 random(9);
  CameraFrames frames;
  frames.captures = {draw(f, s, random)};
  for (int i = 0; i < 4; ++i) {
    ImageF dark(kWidth, kHeight);
    for (float& v : dark.data) v = expose(0.0, s, random);
    frames.dark.push_back(std::move(dark));
  }
  Twin twin = small_twin(f, s);
  twin.cameras[0].sensor.black_level_dn = 0.0;  // the dark images know better
  const CameraPhotometry c = analyse_photometry(twin, {frames}).cameras[0];
  expect_sensor(c, s, 0.05);
  EXPECT_NEAR(c.black_level_dn.value, 64.0, 5.0 * std::max(0.005, c.black_level_dn.sigma));
  EXPECT_NEAR(c.dark_noise_dn.value, 4.0, 4.0 * c.dark_noise_dn.sigma);
  EXPECT_FALSE(c.saturation.reached);
}

TEST(PhotonTransfer, SaturationIsSeen) {
  TrueFringes f;
  f.pitches_px = {16.0};
  f.amplitude_dn = 130.0;
  const TrueSensor s;
  std::mt19937_64 random(10);
  const CameraPhotometry c = measure(f, s, {draw(f, s, random)});
  EXPECT_TRUE(c.saturation.reached);
  EXPECT_EQ(c.saturation.level_dn, 255.0);
  expect_sensor(c, s, 0.05);
}

TEST(PhotonTransfer, SeriesTellGainAndABentSensor) {
  const TrueSensor s;
  std::mt19937_64 random(11);
  CameraFrames frames;
  std::vector<double> truth;
  for (const double ms : {2.0, 5.0, 10.0, 20.0, 40.0, 70.0}) {
    StillSeries series{"", {}, ms};
    const double level = 3.0 * ms * (1.0 - 0.0005 * ms);  // 3.5 % low at the end
    truth.push_back(s.black_dn + level);
    for (int k = 0; k < 3; ++k) {
      ImageF image(kWidth, kHeight);
      for (float& v : image.data) v = expose(level, s, random);
      series.images.push_back(std::move(image));
    }
    frames.series.push_back(std::move(series));
  }
  const CameraPhotometry c = analyse_photometry(small_twin(TrueFringes{}, s), {frames}).cameras[0];
  expect_sensor(c, s, 0.05);
  ASSERT_TRUE(c.linearity);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(c.linearity->level_dn[i] / truth[i], 1.0, 0.001);
  EXPECT_LT(c.linearity->residual_percent.back(), -0.5);  // the bend shows at the end
  EXPECT_TRUE(c.directions.empty());
}

TEST(ProjectorResponse, GammaAndBlur) {
  std::mt19937_64 random(12);
  const TrueSensor s;
  for (const double gamma : {1.0, 2.2}) {
    TrueFringes f;
    f.gamma = gamma;
    f.blur_px = 0.35;
    f.steps = 8;
    f.amplitude_dn = 100.0;
    const CameraPhotometry c = measure(f, s, {draw(f, s, random)});
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
  const CameraPhotometry four = measure(f, s, {draw(f, s, random)});
  EXPECT_NEAR(four.directions[0].gamma.value, 1.8, 0.02);
  EXPECT_TRUE(four.directions[0].curve_light.empty());
  f.steps = 3;
  CameraFrames frames;
  frames.captures = {draw(f, s, random)};
  const Photometry three = analyse_photometry(small_twin(f, s), {frames});
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

TEST(FlatField, VignettingUnderUnevenLight) {
  const TrueSensor s{40.0, 0.5, 5.0, 8};
  std::mt19937_64 random(14);
  const auto truth = [](double r2) { return 1.0 - 0.32 * r2 + 0.09 * r2 * r2 - 0.03 * r2 * r2 * r2; };
  ImageF flat(kWidth, kHeight);
  const auto r2_of = [](int x, int y) {
    return (std::pow(x - 0.5 * (kWidth - 1), 2) + std::pow(y - 0.5 * (kHeight - 1), 2)) /
           (0.25 * (kWidth * kWidth + kHeight * kHeight));
  };
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      flat(x, y) =
          expose(180.0 * truth(r2_of(x, y)) *
                     (1.0 + 0.06 * (x - 0.5 * kWidth) / kWidth - 0.04 * (y - 0.5 * kHeight) / kHeight),
                 s, random);
  const FlatField f = fit_flat_field(flat, 5.0, 255.0, "left");
  for (int y = 0; y < kHeight; y += 10)
    for (int x = 0; x < kWidth; x += 10) {
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
  EXPECT_FALSE(light_of_images({.cameras = {measure(f, s, {draw(f, s, random)})}, .warnings = {}}));
  f.lamp = {0.98, 0.99, 1.0, 1.01, 1.02, 1.02, 0.98, 1.01, 0.99, 1.0};  // a drift, then flicker
  double mean = 0.0;
  for (const double lamp : f.lamp) mean += std::log(lamp) / 10.0;
  Photometry both{.cameras = {measure(f, s, {draw(f, s, random)}), measure(f, s, {draw(f, s, random)})},
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
  both.cameras[1] = measure(f, s, {draw(f, s, random)});
  const std::optional<LightOfImages> differing = light_of_images(both);
  ASSERT_TRUE(differing);
  ASSERT_EQ(differing->exposure_factors.size(), 2u);
  EXPECT_TRUE(differing->exposure_factors[0].empty());
  EXPECT_NEAR(differing->exposure_factors[1].at(2), std::pow(1.01, 0.9), 3e-3);
  EXPECT_EQ(differing->light_factors, both.cameras[0].light->factor);
}

TEST(Photometry, RefusesInOneSentence) {
  const TrueSensor s;
  TrueFringes f;
  f.steps = 4;
  std::mt19937_64 random(15);
  const auto sentence = [&](const CameraFrames& frames) -> std::string {
    try {
      const Photometry p = analyse_photometry(small_twin(f, s), {frames});
      return p.warnings.empty() ? "" : p.warnings.front();
    } catch (const std::exception& e) {
      return e.what();
    }
  };
  CameraFrames black;
  black.captures = {draw(f, s, random)};
  for (ImageF& image : black.captures[0].images) std::fill(image.data.begin(), image.data.end(), 0.0f);
  EXPECT_THAT(sentence(black), HasSubstr("nothing can be told from these images"));
  CameraFrames averaged;  // no noise: rounded expectations
  averaged.captures = {draw(f, {1e6, 0.0, 12.0, 8}, random)};
  EXPECT_THAT(sentence(averaged), HasSubstr("simulated without shot noise?"));
  CameraFrames radiance;
  radiance.captures = {draw(f, s, random)};
  radiance.captures[0].radiance = true;
  EXPECT_THAT(sentence(radiance), HasSubstr("irradiance (EXR)"));
  CameraFrames clipped;
  clipped.captures = {draw(f, s, random)};
  clipped.dark.assign(2, ImageF(kWidth, kHeight));
  EXPECT_THAT(sentence(clipped), HasSubstr("100 % of the dark values are 0"));
}

}  // namespace
}  // namespace fringetwin::calib::photometry_test
