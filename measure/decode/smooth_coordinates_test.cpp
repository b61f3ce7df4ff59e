// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-9 px    a quadratic map is its own fit: rounding
//   5 %        noise left over / predicted, 40,000 pixels that share noise: 4 / sqrt(2 * 40000 / 13) = 5 %
#include "measure/decode/smooth_coordinates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fringetwin::measure::smooth_coordinates_test {
namespace {

constexpr int kSize = 200;

CameraDecode map_of(double (*f)(double, double), double noise_px, double stated_sigma_px) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  CameraDecode decode;
  DirectionDecode d;
  d.coordinate_px = ImageD(kSize, kSize);
  d.coordinate_sigma_px = ImageF(kSize, kSize, static_cast<float>(stated_sigma_px));
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) d.coordinate_px(x, y) = f(x, y) + noise_px * normal(random);
  decode.directions.push_back(d);
  return decode;
}

double quadratic(double x, double y) { return 100 + 0.6 * x - 0.05 * y + 1e-3 * x * x - 5e-4 * x * y; }
double step(double x, double) { return 0.6 * x + (x > 100.5 ? 5.0 : 0.0); }

TEST(SmoothCoordinates, NoiseFallsAsPredictedAndQuadraticsStay) {
  CameraDecode clean = map_of(quadratic, 0.0, 0.1);
  smooth_coordinates(clean, 2.0);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      ASSERT_NEAR(clean.directions[0].coordinate_px(x, y), quadratic(x, y), 1e-9);

  const double noise = 0.1;
  CameraDecode noisy = map_of(quadratic, noise, noise);
  smooth_coordinates(noisy, 2.0);
  double sum = 0.0, predicted = 0.0, n = 0.0;
  for (int y = 3; y < kSize - 3; ++y)
    for (int x = 3; x < kSize - 3; ++x) {
      sum += std::pow(noisy.directions[0].coordinate_px(x, y) - quadratic(x, y), 2);
      predicted += std::pow(static_cast<double>(noisy.directions[0].coordinate_sigma_px(x, y)), 2);
      n += 1.0;
    }
  EXPECT_NEAR(std::sqrt(sum / predicted), 1.0, 0.05);
  EXPECT_LT(std::sqrt(sum / n), 0.7 * noise);
}

TEST(SmoothCoordinates, StepsAndHolesStay) {
  CameraDecode decode = map_of(step, 0.0, 0.05);
  decode.directions[0].coordinate_px(40, 40) = std::nan("");
  smooth_coordinates(decode, 2.0);
  const ImageD& map = decode.directions[0].coordinate_px;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (x == 40 && y == 40)
        ASSERT_TRUE(std::isnan(map(x, y)));
      else
        ASSERT_NEAR(map(x, y), step(x, y), 1e-9);
}

TEST(SmoothCoordinates, WithoutNoiseOrRoomNothingHappens) {
  CameraDecode noisy = map_of(quadratic, 0.1, 0.0);
  const std::vector<double> before = noisy.directions[0].coordinate_px.data;
  smooth_coordinates(noisy, 2.0);  // sigma 0 explains nothing
  EXPECT_EQ(noisy.directions[0].coordinate_px.data, before);
  CameraDecode other = map_of(quadratic, 0.1, 0.1);
  smooth_coordinates(other, 1.0);  // five pixels: too few for a quadratic
  EXPECT_EQ(other.directions[0].coordinate_px.data, before);
  other.directions[0].coordinate_sigma_px = {};
  smooth_coordinates(other, 3.0);
  EXPECT_EQ(other.directions[0].coordinate_px.data, before);
}

}  // namespace
}  // namespace fringetwin::measure::smooth_coordinates_test
