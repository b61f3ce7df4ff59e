// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   5 % and 10 %  variances over some 9,000 values whose windows overlap (radius 4: 49 pixels, 180 windows
//   apart; standard
//                 error of a variance sqrt(2/180) = 10 % at worst, 3 % in the mean of the draws below), and
//                 what robust weights cost beside least squares (5 % of the variance at a normal
//                 distribution: Tukey's biweight)
//   1e-9          a quadratic is told exactly: whole numbers of 2^-30
#include "measure/depth_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

namespace fringetwin::measure::depth_fit_test {
namespace {

constexpr int kSize = 128;

/// Returns the depths of 1/z = 1/800 + shape(x, y), each with this noise of 1/z.
DepthMap map_of(const std::function<double(int, int)>& shape, double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  DepthMap map{ImageD(kSize, kSize, 0.0), ImageF(kSize, kSize, 0.0F), 5e-4};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double z = 1.0 / (1.0 / 800.0 + shape(x, y) + noise * normal(random));
      map.z_mm(x, y) = z;
      map.sigma_mm(x, y) = static_cast<float>(noise * z * z);
    }
  return map;
}

struct Scatter {
  double value = 0.0, slope = 0.0, said_value = 0.0, said_slope = 0.0, radius_px = 0.0;
};

/// Returns the mean squares of what fits inside an image are off by, over the noise of one pixel, beside what
/// the fits say.
Scatter scatter_of(const std::function<double(int, int)>& shape, const std::function<double(int, int)>& slope,
                   double most_px, int border) {
  constexpr double kNoise = 2e-7;
  Scatter s;
  double n = 0.0;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const Image<DepthFit> fits = fit_depths(map_of(shape, kNoise, seed), 4.0, most_px);
    for (int y = border; y < kSize - border; ++y)
      for (int x = border; x < kSize - border; ++x) {
        const DepthFit& fit = fits(x, y);
        s.value += std::pow((fit.inverse_depth - 1.0 / 800.0 - shape(x, y)) / kNoise, 2);
        s.slope += std::pow((fit.slope_x - slope(x, y)) / kNoise, 2);
        s.said_value += static_cast<double>(fit.leverage);
        s.said_slope += static_cast<double>(fit.slope_xx);
        s.radius_px += static_cast<double>(fit.radius_px);
        n += 1.0;
      }
  }
  for (double* sum : {&s.value, &s.slope, &s.said_value, &s.said_slope, &s.radius_px}) *sum /= n;
  return s;
}

double bowl(int x, int y) { return 1e-9 * (x * x + 0.5 * y * y) + 2e-8 * x; }
double bowl_slope(int x, int) { return 2e-9 * x + 2e-8; }

TEST(DepthFit, SaysWhatNoiseIsLeft) {
  const Scatter s = scatter_of(bowl, bowl_slope, 0.0, 8);
  EXPECT_NEAR(s.value / s.said_value, 1.0, 0.10);
  EXPECT_NEAR(s.slope / s.said_slope, 1.0, 0.10);
  EXPECT_DOUBLE_EQ(s.radius_px, 4.0);
}

TEST(DepthFit, WindowsGrowWhereTheSurfaceIsAQuadratic) {
  const Scatter small = scatter_of(bowl, bowl_slope, 0.0, 24), large = scatter_of(bowl, bowl_slope, 16.0, 24);
  std::printf("depth fit: slopes' variance %.2e -> %.2e (said %.2e), radius %.1f px\n", small.slope,
              large.slope, large.said_slope, large.radius_px);
  EXPECT_GT(large.radius_px, 12.0);
  // a radius of 16 for 4 leaves 1/256 of the variance; windows that stop early by chance leave more
  EXPECT_LT(large.slope, small.slope / 20.0);
  // a window is chosen by the noise in it, which is then not quite what it says: half as much again was seen
  EXPECT_NEAR(large.slope / large.said_slope, 1.0, 0.6);
}

TEST(DepthFit, StepsAndCreasesStayWhereTheyAre) {
  const auto roof = [](int x, int) { return 1e-7 * std::abs(x - kSize / 2); };
  const auto step = [](int x, int) { return x < kSize / 2 ? 0.0 : 2e-6; };
  constexpr double kNoise = 2e-8;
  const DepthMap roofs = map_of(roof, kNoise, 3), steps = map_of(step, kNoise, 4);
  const Image<DepthFit> of_roof = fit_depths(roofs, 3.0, 24.0), of_step = fit_depths(steps, 3.0, 24.0);
  for (int y = 30; y < kSize - 30; y += 7)
    for (const int away : {-12, -8, 8, 12}) {
      const int x = kSize / 2 + away;
      // a window beyond the crease or the step would be off by many times the noise of one pixel
      EXPECT_NEAR(of_roof(x, y).slope_x, away < 0 ? -1e-7 : 1e-7, 0.5 * kNoise) << x;
      EXPECT_NEAR(of_step(x, y).inverse_depth - 1.0 / 800.0, step(x, y), 2.0 * kNoise) << x;
      EXPECT_LE(of_step(x, y).radius_px, static_cast<float>(std::abs(away)) + 4.0F);
    }
}

TEST(DepthFit, AQuadraticIsToldExactly) {
  const Image<DepthFit> fits = fit_depths(map_of(bowl, 1e-12, 5), 4.0, 16.0);
  for (int y = 20; y < kSize - 20; y += 11)
    for (int x = 20; x < kSize - 20; x += 11) {
      EXPECT_NEAR(fits(x, y).inverse_depth, 1.0 / 800.0 + bowl(x, y), 1e-9 / 800.0);
      EXPECT_NEAR(fits(x, y).slope_x, bowl_slope(x, y), 1e-9 / 800.0);
    }
}

}  // namespace
}  // namespace fringetwin::measure::depth_fit_test
