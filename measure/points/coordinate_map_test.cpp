// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-9 px    a bicubic polynomial of values up to 1000 is read back by the 4x4 stencil, wherever it is
//   shifted:
//              rounding only
//   1e-12 px   a plane is read back by the bilinear stencil
#include "measure/points/coordinate_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fringetwin::measure::coordinate_map_test {
namespace {

double cubic(double x, double y) {
  return 500 + 0.7 * x - 0.1 * y + 1e-3 * x * x * y - 2e-4 * y * y * y + 1e-4 * x * x * x;
}
double cubic_dx(double x, double y) { return 0.7 + 2e-3 * x * y + 3e-4 * x * x; }
double cubic_dy(double x, double y) { return -0.1 + 1e-3 * x * x - 6e-4 * y * y; }

template <class F>
ImageD image_of(F f, int width = 20, int height = 16) {
  ImageD image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image(x, y) = f(x, y);
  return image;
}

TEST(CoordinateMap, CubicsAreExactToTheBorder) {
  const ImageD image = image_of(cubic);
  const ImageF no_sigma;
  const CoordinateMap map(image, no_sigma);
  for (const double x : {0.0, 0.3, 1.0, 7.5, 17.9, 18.4, 19.0})
    for (const double y : {0.0, 0.6, 8.25, 14.2, 15.0}) {
      MapSample s;
      ASSERT_TRUE(map.sample(x, y, s)) << x << " " << y;
      EXPECT_NEAR(s.value, cubic(x, y), 1e-9);
      EXPECT_NEAR(s.d_dx, cubic_dx(x, y), 1e-9);
      EXPECT_NEAR(s.d_dy, cubic_dy(x, y), 1e-9);
    }
  MapSample s;
  for (const double outside : {-0.01, 19.01, std::nan("")}) EXPECT_FALSE(map.sample(outside, 5, s));
  EXPECT_FALSE(map.sample(5, 15.01, s));
}

TEST(CoordinateMap, HolesShiftTheStencil) {
  ImageD image = image_of(cubic);
  image(10, 8) = std::nan("");
  const ImageF no_sigma;
  const CoordinateMap map(image, no_sigma);
  MapSample s;
  EXPECT_FALSE(map.sample(9.5, 8.5, s));  // a cell with the hole
  EXPECT_FALSE(map.sample(10.5, 7.5, s));
  for (const auto& [x, y] : {std::pair{8.5, 8.0}, {11.5, 8.5}, {10.2, 9.5}, {12.0, 8.0}}) {
    ASSERT_TRUE(map.sample(x, y, s)) << x << " " << y;
    EXPECT_NEAR(s.value, cubic(x, y), 1e-9);
  }
}

TEST(CoordinateMap, NarrowStripsAreReadLinearly) {
  ImageD image = image_of([](double x, double y) { return 3 + 0.5 * x - 0.25 * y; });
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (x < 8 || x > 10) image(x, y) = std::nan("");  // three columns: no room for four
  const ImageF no_sigma;
  const CoordinateMap map(image, no_sigma);
  MapSample s;
  ASSERT_TRUE(map.sample(9.3, 7.6, s));
  EXPECT_NEAR(s.value, 3 + 0.5 * 9.3 - 0.25 * 7.6, 1e-12);
  EXPECT_NEAR(s.d_dx, 0.5, 1e-12);
  EXPECT_NEAR(s.d_dy, -0.25, 1e-12);
}

TEST(CoordinateMap, NothingIsReadAcrossAJump) {
  const double slope = 0.7;
  for (const double jump : {-40.0, -2.0, 2.0, 40.0}) {
    const ImageD image = image_of([&](double x, double) { return slope * x + (x >= 10 ? jump : 0.0); });
    const ImageF no_sigma;
    const CoordinateMap map(image, no_sigma);
    MapSample s;
    EXPECT_FALSE(map.sample(9.5, 7.5, s)) << jump;
    for (const double x : {8.7, 10.3}) {  // the cells beside it use their own side
      ASSERT_TRUE(map.sample(x, 7.5, s));
      EXPECT_NEAR(s.value, slope * x + (x >= 10 ? jump : 0.0), 1e-9);
    }
  }
}

TEST(CoordinateMap, NoiseIsNoJump) {
  ImageD image = image_of([](double x, double) { return 0.7 * x; });
  ImageF sigma(image.width, image.height, 0.2f);
  for (std::size_t i = 0; i < image.size(); ++i) image.data[i] += i % 2 ? 0.2 : -0.2;
  const CoordinateMap map(image, sigma);
  EXPECT_NEAR(map.typical_sigma_px(), 0.2, 1e-7);
  MapSample s;
  EXPECT_TRUE(map.sample(9.5, 7.5, s));
  EXPECT_NEAR(map.sigma_px(9.5, 7.5), 0.2, 1e-7);
  const ImageF no_sigma;
  EXPECT_EQ(CoordinateMap(image, no_sigma).sigma_px(3, 3), 0.0);
}

// Draws of plain normal numbers on a map without slope: 20,000 of them know their standard deviation to
// 0.5 %. The last two places are read with a shifted stencil and linearly. A smoothed map lessens nothing.
TEST(CoordinateMap, NoiseGainIsTheScatterOfDraws) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  ImageD image(7, 8);
  const ImageF sigma(image.width, image.height, 1.0f);
  struct Place {
    double x, y, gain;
  };
  for (const Place& at :
       {Place{3.0, 4.0, 1.0}, {3.5, 4.5, 0.6406}, {2.3, 4.0, 0}, {0.4, 4.6, 0}, {5.5, 0.5, 0}}) {
    const CoordinateMap map(image, sigma), smoothed(image, sigma, true);
    double sum_sq = 0.0, gain = 0.0;
    constexpr int kDraws = 20'000;
    for (int draw = 0; draw < kDraws; ++draw) {
      for (double& v : image.data) v = normal(random);
      if (at.x == 5.5) image(3, 1) = std::nan("");
      MapSample s;
      ASSERT_TRUE(map.sample(at.x, at.y, s));
      sum_sq += s.value * s.value;
      gain = s.noise_gain;
      ASSERT_TRUE(smoothed.sample(at.x, at.y, s));
      ASSERT_EQ(s.noise_gain, 1.0);
    }
    EXPECT_NEAR(std::sqrt(sum_sq / kDraws) / gain, 1.0, 0.03) << at.x << " " << at.y;
    if (at.gain > 0.0) {
      EXPECT_NEAR(gain, at.gain, 0.002);
    }
  }
}

}  // namespace
}  // namespace fringetwin::measure::coordinate_map_test
