// SPDX-License-Identifier: Apache-2.0
// Gain and read noise of drawn images whose sensor is known.
//
// | check                                 | tolerance         | origin                                   |
// |---------------------------------------|-------------------|------------------------------------------|
// | gain, read noise of each draw         | 4 sigma           | its own sigma                            |
// | scatter over 12 draws / printed sigma | 0.5 ... 1.5       | a scatter of 12 is known to 20 %         |
// | mean error over 5 and 10 draws        | 4 standard errors | its own sigma over the root of the draws |
// | gain with edges, harmonics, flicker   | 4 sigma; 2 % from | its own sigma; issue: 3 %                |
// |                                       | repeats           |                                          |
// | levels of exposures                   | 0.1 %             | drawn                                    |
#include "calib/photometry/photon_transfer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/calib/drawn_photometry.hpp"

namespace fringetwin::calib::photon_transfer_test {
namespace {

using namespace testing;

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
      std::vector<CameraImages> captures{drawn_fringes(f, s, random)};
      if (repeats) captures.push_back(drawn_fringes(f, s, random));
      const CameraPhotometry c = photometry_of(f, s, captures);
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
    const CameraPhotometry c = photometry_of(f, s, {drawn_fringes(f, s, random)});
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
    std::vector<CameraImages> captures{drawn_fringes(f, s, random)};
    if (repeats) captures.push_back(drawn_fringes(f, s, random));
    const CameraPhotometry c = photometry_of(f, s, captures);
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
  frames.captures = {drawn_fringes(f, s, random)};
  for (int i = 0; i < 4; ++i) {
    ImageF dark(kDrawnWidth, kDrawnHeight);
    for (float& v : dark.data) v = expose(0.0, s, random);
    frames.dark.push_back(std::move(dark));
  }
  Twin twin = photometry_twin(f, s);
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
  const CameraPhotometry c = photometry_of(f, s, {drawn_fringes(f, s, random)});
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
      ImageF image(kDrawnWidth, kDrawnHeight);
      for (float& v : image.data) v = expose(level, s, random);
      series.images.push_back(std::move(image));
    }
    frames.series.push_back(std::move(series));
  }
  const CameraPhotometry c = analyse_photometry(photometry_twin(TrueFringes{}, s), {frames}).cameras[0];
  expect_sensor(c, s, 0.05);
  ASSERT_TRUE(c.linearity);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(c.linearity->level_dn[i] / truth[i], 1.0, 0.001);
  EXPECT_LT(c.linearity->residual_percent.back(), -0.5);  // the bend shows at the end
  EXPECT_TRUE(c.directions.empty());
}

// A sensor without fault under light that falls off: at long exposures the middle is saturated, later nearly
// all is.
TEST(PhotonTransfer, SaturatedPixelsDoNotBendTheLine) {
  const TrueSensor s;
  std::mt19937_64 random(12);
  CameraFrames frames;
  for (const double ms : {2.0, 5.0, 10.0, 20.0, 30.0, 80.0}) {
    StillSeries series{"", {}, ms};
    for (int k = 0; k < 2; ++k) {
      ImageF image(kDrawnWidth, kDrawnHeight);
      for (int y = 0; y < kDrawnHeight; ++y)
        for (int x = 0; x < kDrawnWidth; ++x)
          image(x, y) = expose(ms * (11.0 - 5.0 * std::abs(2.0 * x / kDrawnWidth - 1.0)), s, random);
      series.images.push_back(std::move(image));
    }
    frames.series.push_back(std::move(series));
  }
  const Photometry photometry = analyse_photometry(photometry_twin(TrueFringes{}, s), {frames});
  const CameraPhotometry& c = photometry.cameras[0];
  ASSERT_TRUE(c.linearity);
  EXPECT_EQ(c.linearity->exposure_ms, (std::vector<double>{2, 5, 10, 20, 30}));
  // each level is the mean of thousands of pixels: 1e-3
  EXPECT_LT(std::abs(c.linearity->worst_percent), 0.2);
  EXPECT_NEAR(c.linearity->offset_dn.value, s.black_dn, 0.1);
  const auto warned = [&](const std::string& text) {
    return std::ranges::any_of(photometry.warnings,
                               [&](const std::string& w) { return w.find(text) != w.npos; });
  };
  EXPECT_TRUE(warned("at 80 ms are at 255 DN, where they end: it takes no part"));
  EXPECT_TRUE(warned("at 30 ms are at 255 DN, where they end: level against exposure is told by"));
}

/// Level against exposure of an evenly lit plate, the longest exposure at `last_dn`. `stuck`: a pixel that is
/// always full.
ExposureLinearity even_light(double last_dn, bool stuck, std::vector<std::string>& warnings) {
  const TrueSensor s;
  std::mt19937_64 random(13);
  CameraFrames frames;
  for (const double part : {0.1, 0.3, 0.5, 0.8, 1.0}) {
    StillSeries series{"", {}, 10.0 * part};
    for (int k = 0; k < 2; ++k) {
      ImageF image(kDrawnWidth, kDrawnHeight);
      for (float& v : image.data) v = expose(part * (last_dn - s.black_dn), s, random);
      if (stuck) image(40, 40) = 255.0f;
      series.images.push_back(std::move(image));
    }
    frames.series.push_back(std::move(series));
  }
  const Photometry photometry = analyse_photometry(photometry_twin(TrueFringes{}, s), {frames});
  warnings = photometry.warnings;
  return photometry.cameras[0].linearity.value();
}

// Where all of the image is near saturation, pixels that are still below it are those that noise has
// darkened.
TEST(PhotonTransfer, NoiseNearSaturationDoesNotBendTheLine) {
  for (const double last_dn : {225.0, 235.0, 240.0, 243.0, 246.0, 250.0}) {
    std::vector<std::string> warnings;
    const ExposureLinearity l = even_light(last_dn, false, warnings);
    EXPECT_LT(std::abs(l.worst_percent), 0.1) << last_dn << ", " << l.exposure_ms.size() << " series";
    EXPECT_EQ(l.exposure_ms.size(), last_dn > 246.0 ? 4u : 5u) << last_dn;
  }
}

TEST(PhotonTransfer, ADefectivePixelIsNoSaturation) {
  std::vector<std::string> warnings;
  EXPECT_EQ(even_light(150.0, true, warnings).exposure_ms.size(), 5u);
  for (const std::string& w : warnings) EXPECT_EQ(w.find("at 255 DN"), w.npos) << w;
}

}  // namespace
}  // namespace fringetwin::calib::photon_transfer_test
