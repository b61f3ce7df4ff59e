// SPDX-License-Identifier: Apache-2.0
// Images with noise -> decode() -> errors against the predicted sigma, orders, repair.
// | check                                | tolerance | unit | origin |
// |--------------------------------------|-----------|------|----------------------------------------------------|

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstring>
#include <iostream>

#include "measure/decode/decode.hpp"
#include "tests/support/measure/synthetic_fringes.hpp"
#include "tests/support/twin/random_values.hpp"

namespace fringetwin::measure::decode_noise_test {
namespace {

using testing::decode_errors;
using testing::DecodeErrors;
using testing::FringeScene;
using testing::gray_fringes;
using testing::noisy_scene;
using testing::one_direction;
using testing::project;
using testing::projector_of_width;
using testing::ramp;

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

TEST(DecodeNoise, SigmaPredictsTheErrorForAllModesAndSubsets) {
  const GrayCode code{5, false, true, -0.5, GrayCode::Threshold::mean};
  const Fringes all[] = {one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 1, 2}),
                         one_direction(Unwrap::heterodyne, 8, {13, 14, 15}, {0, 1, 2}),
                         one_direction(Unwrap::hierarchical, 12, {1280, 160, 20}, {640, 80, 10}),
                         gray_fringes(12, 40, 20, code)};
  for (const Fringes& f : all) {
    FringeScene scene = noisy_scene(1.5);
    const CameraImages images = project(f, scene);
    DecodeOptions o = projector_of_width(1280);
    const CameraDecode d = decode(images, f, o);
    EXPECT_EQ(d.directions[0].noise_source, NoiseSource::residuals);
    EXPECT_NEAR(d.directions[0].noise_dn, std::sqrt(1.5 * 1.5 + 1.0 / 12.0), 0.05 * 1.5) << f.steps;
    EXPECT_NEAR(normalised_rms(d.directions[0], scene.column_px), 1.0, 0.1) << f.steps << " steps";
    EXPECT_EQ(decode_errors(d.directions[0], scene.column_px).n_wrong, 0u) << f.steps;
    if (f.steps < 8) continue;
    o.use_steps = {0, 1, 3, 6};  // uneven: sigma depends on the phase
    EXPECT_NEAR(normalised_rms(decode(images, f, o).directions[0], scene.column_px), 1.0, 0.1) << "subset";
    o.use_steps = {0, 2, 4, 6};
    EXPECT_EQ(decode_errors(decode(images, f, o).directions[0], scene.column_px).n_wrong, 0u) << "even steps";
  }
}

TEST(DecodeNoise, KnownNoiseIsUsedAsGiven) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  const FringeScene scene = noisy_scene(2.0);
  DecodeOptions o = projector_of_width(1280);
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

TEST(DecodeNoise, QuantisationIsTheFloor) {
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  const FringeScene scene = noisy_scene(0.0);
  const CameraDecode d = decode(project(f, scene), f, projector_of_width(1280));
  EXPECT_GE(d.directions[0].noise_dn, 0.288);
  EXPECT_LT(d.directions[0].noise_dn, 0.35);
  EXPECT_LT(normalised_rms(d.directions[0], scene.column_px), 1.2);
  EXPECT_GT(normalised_rms(d.directions[0], scene.column_px), 0.7);
  const Fringes three = one_direction(Unwrap::heterodyne, 3, {13, 14, 15}, {0, 0, 0});
  EXPECT_EQ(decode(project(three, scene), three, projector_of_width(1280)).directions[0].noise_source,
            NoiseSource::quantisation);
}

TEST(DecodeNoise, HarmonicsOfTheProjectorAreNotNoise) {
  // A gamma of 2 puts a strong second harmonic into the residuals; its second difference along the
  // stripes is small.
  const Fringes f = one_direction(Unwrap::hierarchical, 8, {1280, 160, 20}, {640, 80, 10});
  FringeScene scene = noisy_scene(0.0);
  scene.quantised = false;
  scene.column_px = ramp(400, 200, 2.0, 1277.0, 10.0);
  CameraImages images = project(f, scene);
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats()) {
      const double share = static_cast<double>(v) / 210.0;
      v = static_cast<float>(std::round(210.0 * share * share + normal(random)));
    }
  images.radiance = false;
  const CameraDecode d = decode(images, f, projector_of_width(1280));
  EXPECT_NEAR(d.directions[0].noise_dn, std::sqrt(1.0 + 1.0 / 12.0), 0.07);
}

// ---- properties -------------------------------------------------------------------------------------

RC_GTEST_PROP(DecodeNoise, HeterodyneWithNoiseWithinTheTolerance, ()) {
  const int steps = *rc::gen::inRange(3, 9);
  std::vector<double> origins;
  for (int i = 0; i < 3; ++i) origins.push_back(*fringetwin::testing::uniform(-2000.0, 2000.0));
  const double scale = *fringetwin::testing::uniform(1.0, 3.0);
  const Fringes f = one_direction(Unwrap::heterodyne, steps, {14 * scale, 13 * scale, 15 * scale}, origins);
  const double width = std::floor(1280 * scale);
  FringeScene scene;
  scene.column_px = ramp(110, 9, 2.0, width - 3.0, 0.01 * width);
  // Phase sigma 0.03 rad or less: sqrt(2/N) noise / 100 DN.
  scene.noise_dn = *fringetwin::testing::uniform(0.0, 3.0) * std::sqrt(steps / 2.0);
  scene.seed = *rc::gen::arbitrary<unsigned>();
  const DecodeErrors e =
      decode_errors(decode(project(f, scene), f, projector_of_width(width)).directions[0], scene.column_px);
  RC_ASSERT(e.n_wrong == 0u);
  RC_ASSERT(e.n_valid >= scene.column_px.size() - 5);
}

RC_GTEST_PROP(DecodeNoise, GrayCodeOfAnyKindWithNoise, ()) {
  const int steps = *rc::gen::inRange(3, 13), bits = *rc::gen::inRange(3, 7);
  GrayCode code;
  code.bits = bits;
  code.lsb_first = *rc::gen::arbitrary<bool>();
  code.complementary = *rc::gen::arbitrary<bool>();
  code.offset_periods = *fringetwin::testing::uniform(-1.0, 1.0);
  code.threshold = *rc::gen::element(GrayCode::Threshold::mean, GrayCode::Threshold::inverse,
                                     GrayCode::Threshold::white_black);
  const double pitch = *fringetwin::testing::uniform(12.0, 60.0);
  const Fringes f = gray_fringes(steps, pitch, *fringetwin::testing::uniform(-900.0, 900.0), code);
  const double width = std::floor(pitch * std::ldexp(1.0, bits));
  // 12 camera pixels a period: the footprint is a camera pixel.
  const int w = 12 << bits;
  FringeScene scene;
  scene.column_px = ramp(w, 8, 0.0, width - 1.0, 0.3 * pitch);
  scene.footprint_px = pitch / 12.0;
  scene.noise_dn =
      *fringetwin::testing::uniform(0.0, 2.0) * std::sqrt(steps / 2.0);  // phase sigma up to 0.02 rad
  scene.seed = *rc::gen::arbitrary<unsigned>();
  const DirectionDecode d = decode(project(f, scene), f, projector_of_width(width)).directions[0];
  const DecodeErrors e = decode_errors(d, scene.column_px);
  RC_ASSERT(e.n_wrong == 0u);
  RC_ASSERT(d.repair.n_left == 0u);
  RC_ASSERT(e.n_valid >= scene.column_px.size() * 98 / 100);  // the borders of the projector
}

TEST(DecodeNoise, ErrorsOfHardCodeEdgesAreRepairedAndCounted) {
  // Edges sharper than a pixel and phase noise: some orders are wrong before the repair.
  const Fringes f = gray_fringes(4, 40, 0, {5, false, false, 0.0, GrayCode::Threshold::mean});
  FringeScene scene = noisy_scene(4.0);
  scene.footprint_px = 0.0;
  const CameraImages images = project(f, scene);
  DecodeOptions o = projector_of_width(1280);
  o.repair_orders = false;
  const DirectionDecode raw = decode(images, f, o).directions[0];
  const DecodeErrors before = decode_errors(raw, scene.column_px);
  EXPECT_GT(before.n_wrong, 50u);
  EXPECT_GT(raw.repair.n_left, 50u);
  EXPECT_EQ(raw.repair.n_changed, 0u);
  o.repair_orders = true;
  const DirectionDecode mended = decode(images, f, o).directions[0];
  EXPECT_EQ(decode_errors(mended, scene.column_px).n_wrong, 0u);
  EXPECT_EQ(mended.repair.n_changed, before.n_wrong);
  EXPECT_EQ(mended.repair.n_left, 0u);
}

TEST(DecodeNoise, OrdersThatNoiseMakesAGuessAreNotCalledValid) {
  // sigma 0.09 ... 0.44 rad, the stages tolerate 0.061: beyond twice that nothing is valid, below it
  // nearly all of what is valid is right.
  const Fringes f = one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  for (const double noise_dn : {8.0, 12.0, 25.0}) {
    const FringeScene scene = noisy_scene(noise_dn);
    const CameraDecode d = decode(project(f, scene), f, projector_of_width(1280));
    const DecodeErrors e = decode_errors(d.directions[0], scene.column_px);
    std::cout << "noise " << noise_dn << " DN: " << e.n_valid << " valid, " << e.n_wrong << " wrong of "
              << scene.column_px.size() << "\n";
    EXPECT_LE(e.n_wrong, e.n_valid / 25) << noise_dn;
    if (noise_dn > 20.0) {
      EXPECT_EQ(e.n_valid, 0u);
    }
  }
}

TEST(DecodeNoise, FringesFinerThanThePixelsLoseTheirModulation) {
  // A pixel that covers whole periods sees no modulation; one that covers 0.9 of them little.
  const Fringes f = one_direction(Unwrap::hierarchical, 4, {1280, 160, 16}, {0, 0, 0});
  FringeScene scene;
  scene.column_px = ramp(200, 4, 20.0, 1200.0);
  CameraImages images = project(f, scene);
  const std::vector<PatternSpec> sequence = expand_sequence(f);
  for (std::size_t i = 0; i < images.images.size(); ++i) {
    if (f.directions[0].pitches_px[static_cast<std::size_t>(sequence[i].pitch)] > 16.0) continue;
    for (std::size_t k = 0; k < scene.column_px.size(); ++k)
      images.images[i].as_floats()[k] = static_cast<float>(
          std::round(10.0 + 200.0 * testing::bit_average(f, sequence[i], scene.column_px.data[k], 16.0)));
  }
  const CameraDecode d = decode(images, f, projector_of_width(1280));
  for (const unsigned char flag : d.flags.data) ASSERT_EQ(flag, kLowModulation);
  for (const double x : d.directions[0].coordinate_px.data) ASSERT_TRUE(std::isnan(x));
  EXPECT_TRUE(std::isfinite(d.directions[0].wrapped_rad[0](100, 2)));
}

/// Four steps of three pitches, and eight of others: a lamp that drifts by 2 % either way and flickers by 1
/// %.
std::vector<std::pair<Fringes, std::vector<double>>> flickering() {
  std::vector<std::pair<Fringes, std::vector<double>>> all{
      {one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 1, 2}), {}},
      {one_direction(Unwrap::hierarchical, 8, {1280, 160, 20}, {640, 80, 10}), {}}};
  for (auto& [fringes, light] : all) {
    const auto n = static_cast<double>(expand_sequence(fringes).size());
    for (int k = 0; k < static_cast<int>(n); ++k)
      light.push_back((0.98 + 0.04 * k / (n - 1.0)) * (k % 3 == 1 ? 1.01 : 1.0));
  }
  return all;
}

TEST(DecodeNoise, LightThatChangesIsTakenOut) {
  for (const auto& [fringes, light] : flickering()) {
    FringeScene scene = noisy_scene(0.7);
    scene.light = light;
    const CameraImages images = project(fringes, scene);
    DecodeOptions o = projector_of_width(1280);
    const CameraDecode as_it_is = decode(images, fringes, o);
    EXPECT_FALSE(as_it_is.light || as_it_is.light_taken_out);
    // the sigma of residuals holds a part of the flicker, too
    EXPECT_GT(normalised_rms(as_it_is.directions[0], scene.column_px), 1.15) << fringes.steps;
    o.light = LightOptions{.black_level_dn = scene.black_dn};
    const CameraDecode d = decode(images, fringes, o);
    ASSERT_TRUE(d.light && d.light_taken_out);
    EXPECT_NEAR(normalised_rms(d.directions[0], scene.column_px), 1.0, 0.05) << fringes.steps;
    EXPECT_NEAR(d.directions[0].noise_dn, std::sqrt(0.49 + 1.0 / 12.0), 0.05) << fringes.steps;
    EXPECT_FALSE(d.clip);
  }
}

// A steady lamp: not a bit changes. Were the factors taken out that chance makes, no phase would move by more
// than a tenth of its noise.
TEST(DecodeNoise, SteadyLightIsLeftAlone) {
  for (const auto& [fringes, light] : flickering()) {
    const FringeScene scene = noisy_scene(0.7);
    const CameraImages images = project(fringes, scene);
    DecodeOptions o = projector_of_width(1280);
    const CameraDecode as_it_is = decode(images, fringes, o);
    o.light = LightOptions{.black_level_dn = scene.black_dn};
    const CameraDecode d = decode(images, fringes, o);
    ASSERT_TRUE(d.light);
    EXPECT_FALSE(d.light_taken_out);
    o.light.reset();
    const CameraDecode forced = decode(with_steady_light(images, *d.light, scene.black_dn), fringes, o);
    const DirectionDecode &a = as_it_is.directions[0], &b = d.directions[0], &c = forced.directions[0];
    std::size_t n_lost = 0;
    for (std::size_t i = 0; i < a.coordinate_px.size(); ++i) {
      if (!std::isfinite(a.coordinate_px.data[i])) continue;
      ASSERT_EQ(a.coordinate_px.data[i], b.coordinate_px.data[i]);
      if (!std::isfinite(c.coordinate_px.data[i])) {  // at the border of the projector's image
        ++n_lost;
        continue;
      }
      ASSERT_NEAR(a.coordinate_px.data[i], c.coordinate_px.data[i],
                  0.1 * static_cast<double>(a.coordinate_sigma_px.data[i]));
    }
    EXPECT_LT(n_lost, 10u);
  }
}

TEST(DecodeNoise, TheNumberOfThreadsChangesNoBit) {
  const Fringes f = gray_fringes(4, 40, 0, {5, false, false, 0.0, GrayCode::Threshold::mean});
  FringeScene scene = noisy_scene(4.0);
  scene.footprint_px = 0.0;  // many repairs
  const CameraImages images = project(f, scene);
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const CameraDecode one = decode(images, f, projector_of_width(1280));
  omp_set_num_threads(3);
  const CameraDecode three = decode(images, f, projector_of_width(1280));
  omp_set_num_threads(before);
  EXPECT_EQ(one.flags.data, three.flags.data);
  const DirectionDecode &a = one.directions[0], &b = three.directions[0];
  const auto same = [](const auto& p, const auto& q) {
    return std::memcmp(p.data.data(), q.data.data(), p.size() * sizeof p.data[0]) == 0;
  };
  EXPECT_TRUE(same(a.coordinate_px, b.coordinate_px));
  EXPECT_TRUE(same(a.coordinate_sigma_px, b.coordinate_sigma_px));
  EXPECT_TRUE(same(a.wrapped_rad[0], b.wrapped_rad[0]));
  EXPECT_TRUE(same(a.sigma_rad, b.sigma_rad));
  EXPECT_EQ(a.repair.n_changed, b.repair.n_changed);
  EXPECT_EQ(a.repair.n_left, b.repair.n_left);
}

}  // namespace
}  // namespace fringetwin::measure::decode_noise_test
