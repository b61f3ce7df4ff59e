// SPDX-License-Identifier: Apache-2.0
// Noise that was put in, found again; a sensor model that is wrong by a known factor.
//
// | check                    | tolerance       | origin                                              |
// |--------------------------|-----------------|-----------------------------------------------------|
// | ratios                   | 3 printed sigma | one draw                                            |
// | printed sigma            | 1 %             | 20,000 values: 0.5 %; larger would hide the factor  |
// | quantiles within 2 sigma | 0.1 sigma       | 20 / sqrt(n) at the ends, 1.5 DN rounded to 1 DN    |
#include "compare/gray/noise_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "measure/measurement.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::noise_check_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

SidesTruth truth() {
  SidesTruth t;
  t.noise_dn = 1.5;
  return t;
}

/// The rows after the real images went through the decoder.
std::vector<NoiseRow> rows_of(SyntheticSides& scene, const std::vector<int>& used_steps = {},
                              const CameraImages* irradiance = nullptr) {
  const Camera& camera = scene.twin.cameras[0];
  const CameraImages& images = scene.real.images[0];
  const measure::CameraDecode decode = measure::decode(
      images, scene.twin.fringes, measure::decode_options(scene.twin, camera, images, used_steps));
  return noise_rows(camera, scene.twin.fringes, images, decode, used_steps, irradiance);
}

void expect_ratio(double ratio, double sigma, double truth) {
  EXPECT_NEAR(ratio, truth, 3.0 * sigma);
  EXPECT_GT(sigma, 0.0);
  EXPECT_LT(sigma, 0.01 * ratio);
}

TEST(NoiseCheck, ARightSensorModelGivesOne) {
  SyntheticSides scene = testing::make_sides(truth());
  scene.twin.cameras[0].sensor.read_noise_dn = 1.5;
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  const NoiseRow& r = rows[0];
  EXPECT_TRUE(r.sensor_known);
  EXPECT_EQ(r.direction, "x");
  expect_ratio(r.gray_ratio, r.gray_ratio_sigma, 1.0);
  expect_ratio(r.phase_ratio, r.phase_ratio_sigma, 1.0);
  EXPECT_NEAR(r.gray_measured_dn, std::sqrt(1.5 * 1.5 + 1.0 / 12.0), 3.0 * r.gray_ratio_sigma * 1.53);
  EXPECT_NEAR(r.phase_measured_rad / r.phase_predicted_rad, 1.0, 0.03);  // a median of 9,000 values: 1 %
  for (std::size_t i = 0; i < r.normal_quantile.size(); ++i)
    if (std::abs(r.normal_quantile[i]) <= 2.0) {
      EXPECT_NEAR(r.residual_quantile[i], r.normal_quantile[i], 0.1);
    }
  EXPECT_GT(r.normal_quantile.back(), 3.0);
}

TEST(NoiseCheck, AModelThatIsTooQuietGivesTheFactor) {
  SyntheticSides scene = testing::make_sides(truth());
  scene.twin.cameras[0].sensor.read_noise_dn = 1.0;
  const double factor = std::sqrt((1.5 * 1.5 + 1.0 / 12.0) / (1.0 + 1.0 / 12.0));
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  expect_ratio(rows[0].gray_ratio, rows[0].gray_ratio_sigma, factor);
  expect_ratio(rows[0].phase_ratio, rows[0].phase_ratio_sigma, factor);
  EXPECT_NEAR(rows[0].gray_predicted_dn, std::sqrt(1.0 + 1.0 / 12.0), 1e-9);
  EXPECT_NEAR(rows[0].gray_measured_dn / rows[0].gray_predicted_dn, factor, 4.0 * rows[0].gray_ratio_sigma);
}

TEST(NoiseCheck, ShotNoiseIsRightAtEveryLevel) {
  SidesTruth t = truth();
  t.noise_dn = 0.0;
  t.round_real = false;
  SyntheticSides scene = testing::make_sides(t);
  Sensor& sensor = scene.twin.cameras[0].sensor;
  sensor.electrons_per_dn = 20.0;
  sensor.black_level_dn = t.black_level_dn;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (GrayImage& image : scene.real.images[0].images)
    for (float& v : image.as_floats()) {
      const double dn = static_cast<double>(v);
      v = static_cast<float>(std::round(dn + std::sqrt((dn - t.black_level_dn) / 20.0) * normal(random)));
    }
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  expect_ratio(rows[0].gray_ratio, rows[0].gray_ratio_sigma, 1.0);
  expect_ratio(rows[0].phase_ratio, rows[0].phase_ratio_sigma, 1.0);
  ASSERT_GT(rows[0].levels.size(), 10u);
  for (const NoiseLevel& l : rows[0].levels)
    EXPECT_NEAR(l.measured_dn / l.predicted_dn, 1.0, 4.0 / std::sqrt(2.0 * static_cast<double>(l.n)))
        << l.level_dn;
}

TEST(NoiseCheck, TheMapShowsWhereTheRigIsNoisier) {
  SyntheticSides scene = testing::make_sides(truth());
  scene.twin.cameras[0].sensor.read_noise_dn = 1.5;
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal(0.0, 2.0);
  for (GrayImage& image : scene.real.images[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = 96; x < image.width; ++x)
        image.writable(x, y) =
            static_cast<float>(std::round(static_cast<double>(image(x, y)) + normal(random)));
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  const ImageF& map = rows[0].ratio_map;
  ASSERT_EQ(map.width, 8);
  const int middle = map.height / 2;
  EXPECT_NEAR(map(2, middle), 1.0f, 0.15f);
  EXPECT_NEAR(map(5, middle), 1.67f, 0.25f);  // sqrt(1.5^2 + 2^2 + 2/12) / 1.53
  EXPECT_TRUE(std::isnan(map(0, 0)));         // nothing is seen there
}

TEST(NoiseCheck, WithoutASensorModelThePredictionIsRounding) {
  SyntheticSides scene = testing::make_sides(truth());
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_FALSE(rows[0].sensor_known);
  EXPECT_NEAR(rows[0].gray_predicted_dn, std::sqrt(1.0 / 12.0), 1e-9);
  EXPECT_NEAR(rows[0].gray_ratio, std::sqrt(12.0 * 1.5 * 1.5 + 1.0), 3.0 * rows[0].gray_ratio_sigma);
}

TEST(NoiseCheck, HarmonicsTextureAndGeometryAreNoNoise) {
  SidesTruth t = truth();
  t.second_harmonic = 0.05;  // 8 DN in the residual of every pixel
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = 1.5;
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(rows[0].gray_ratio, 1.0, 0.03);  // the harmonic is smooth along the stripes, but not constant
}

TEST(NoiseCheck, ShapeShowsInThePhaseAlone) {
  SidesTruth t = truth();
  t.geometry_rad = 0.05;
  t.steps = 4;
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = 1.5;
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_GT(rows[0].phase_ratio, 2.0);
  EXPECT_NEAR(rows[0].gray_ratio, 1.0, 0.03);
  t.noise_dn = 0.0;
  t.round_real = false;
  const SyntheticSides twin = testing::make_sides(t);  // has that shape
  const auto apart = rows_of(scene, {}, &twin.real.images[0]);
  ASSERT_EQ(apart.size(), 1u);
  expect_ratio(apart[0].phase_ratio, apart[0].phase_ratio_sigma, 1.0);
}

TEST(NoiseCheck, EverySecondStepOfTwelve) {
  SidesTruth t = truth();
  t.steps = 12;
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = 1.5;
  const auto rows = rows_of(scene, {1, 3, 5, 7, 9, 11});
  ASSERT_EQ(rows.size(), 1u);
  expect_ratio(rows[0].gray_ratio, rows[0].gray_ratio_sigma, 1.0);
  expect_ratio(rows[0].phase_ratio, rows[0].phase_ratio_sigma, 1.0);
}

SidesTruth three_steps() {
  SidesTruth t = testing::deep_truth(60.0);
  t.width = 384;
  t.height = 320;
  t.steps = 3;
  t.twin_gain_dn = 200.0;
  return t;
}

TEST(NoiseCheck, ThreeStepsTellTheirNoiseBetweenThePitches) {
  for (const double factor : {0.5, 1.0, 6.0}) {
    SyntheticSides scene = testing::make_sides(three_steps());
    const double total = std::sqrt(16.0 + 1.0 / 12.0);
    scene.twin.cameras[0].sensor.read_noise_dn = std::sqrt(std::pow(factor * total, 2) - 1.0 / 12.0);
    const auto rows = rows_of(scene);
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_EQ(rows[0].source, "pitches");
    expect_ratio(rows[0].gray_ratio, rows[0].gray_ratio_sigma, 1.0 / factor);
    EXPECT_NEAR(rows[0].gray_measured_dn, total, 0.03 * total);
  }
}

TEST(NoiseCheck, TextureIsNoNoiseBetweenThePitches) {
  SidesTruth t = three_steps();
  t.albedo_sigma = 0.05;  // 25 times the noise from pixel to pixel, the same in all images
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = 4.0;
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(rows[0].gray_ratio, 1.0, 0.1);  // few triples are smooth enough
}

TEST(NoiseCheck, ABrighterPitchIsNoNoise) {
  SyntheticSides scene = testing::make_sides(three_steps());
  scene.twin.cameras[0].sensor.read_noise_dn = 4.0;
  for (int k = 3; k < 6; ++k)  // 2 % flicker: 20 DN between the means
    for (float& v : scene.real.images[0].images[static_cast<std::size_t>(k)].as_floats())
      v = static_cast<float>(std::round(1.02 * static_cast<double>(v)));
  const auto rows = rows_of(scene);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(rows[0].gray_ratio, 1.0, 0.03);
}

TEST(NoiseCheck, ThreeStepsOfOnePitchAskTheNeighbours) {
  SidesTruth t = three_steps();
  t.pitches_px = {13};
  t.gray_bits = 6;
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = 4.0;
  const auto rows = noise_rows(scene.twin.cameras[0], scene.twin.fringes, scene.real.images[0],
                               scene.real.measurement->cameras[0], {});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].source, "neighbours");
  expect_ratio(rows[0].gray_ratio, rows[0].gray_ratio_sigma, 1.0);
}

TEST(NoiseCheck, NoiseStatedSoLargeThatNoOrderIsFoundIsStillToldWrong) {
  for (const int steps : {3, 4}) {
    SidesTruth t = three_steps();
    t.steps = steps;
    SyntheticSides scene = testing::make_sides(t);
    const Camera& camera = scene.twin.cameras[0];
    scene.twin.cameras[0].sensor.read_noise_dn = 80.0;
    measure::CameraDecode decode = scene.real.measurement->cameras[0];
    for (unsigned char& flags : decode.flags.data) flags |= measure::kOrderInvalid;
    const auto rows = noise_rows(camera, scene.twin.fringes, scene.real.images[0], decode, {});
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_NEAR(rows[0].gray_ratio, 0.05, 0.002);
    EXPECT_EQ(rows[0].source, steps == 3 ? "pitches" : "steps");
  }
}

TEST(NoiseCheck, NothingToSayOfIrradiance) {
  SyntheticSides radiance = testing::make_sides(truth());
  radiance.real.images[0].radiance = true;
  EXPECT_TRUE(rows_of(radiance).empty());
}

}  // namespace
}  // namespace fringetwin::compare::noise_check_test
