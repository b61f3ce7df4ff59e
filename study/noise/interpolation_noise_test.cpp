// SPDX-License-Identifier: Apache-2.0
// | tolerance | origin                                                                          |
// |-----------|---------------------------------------------------------------------------------|
// | 1e-14     | rounding of sums of a few terms                                                  |
// | 2e-4      | the table's straight lines (1e-4) and the mean over 400 places instead of all    |
// | 2e-3      | lattices below 1 px: the kernel's spectrum at their frequencies (measured: 1e-3)  |
#include "study/noise/interpolation_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "measure/points/coordinate_map.hpp"

namespace fringetwin::study::interpolation_noise_test {
namespace {

constexpr int kSize = 16;

/// What the measurement reads at (x, 8) when pixel (i, 8) is 1 and the others 0.
double weight(double x, int i) {
  const auto read = [&](double bump) {
    ImageD map(kSize, kSize);
    for (int v = 0; v < kSize; ++v)
      for (int u = 0; u < kSize; ++u) map(u, v) = u + v;  // what has no slope is taken for a jump
    map(i, 8) += bump;
    measure::MapSample sample;
    EXPECT_TRUE(measure::CoordinateMap(map, {}).sample(x, 8.0, sample));
    return sample.value;
  };
  return (read(1e-3) - read(0.0)) / 1e-3;
}

TEST(InterpolationNoise, IsThatOfTheMeasurementsInterpolation) {
  constexpr int places = 400;
  for (const double distance : {0.0, 0.31, 1.0, 1.5, 2.7, 3.4}) {
    double sum = 0.0;
    for (int k = 0; k < places; ++k) {
      const double x = 6.0 + (k + 0.5) / places;
      for (int i = 0; i < kSize; ++i) sum += weight(x, i) * weight(x + distance, i);
    }
    EXPECT_NEAR(interpolation_covariance(distance), sum / places, 2e-4) << distance;
    EXPECT_EQ(interpolation_covariance(-distance), interpolation_covariance(distance));
  }
}

TEST(InterpolationNoise, KnownValues) {
  EXPECT_NEAR(interpolation_covariance(0.0), 733.0 / 945.0, 1e-14);
  EXPECT_EQ(interpolation_covariance(4.0), 0.0);
  EXPECT_EQ(interpolation_covariance(100.0), 0.0);
}

Eigen::Matrix2d lattice(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

TEST(InterpolationNoise, ASumOverADenseLatticeHasAllOfThePixelsNoise) {
  EXPECT_NEAR(lattice_variance(lattice(1, 0, 0, 1)), 1.0, 1e-14) << "the weights of each pixel sum up to 1";
  for (const Eigen::Matrix2d& m :
       {lattice(0.5, 0, 0, 0.9), lattice(0.3, 0.1, -0.2, 0.7), lattice(0, -0.8, 0.6, 0)})
    EXPECT_NEAR(lattice_variance(m) * std::abs(m.determinant()), 1.0, 2e-3) << m;
  EXPECT_NEAR(lattice_variance(lattice(0.01, 0, 0, 1)), 100.0, 1e-14 * 100.0);
  const double before = lattice_variance(lattice(0.0624, 0, 0, 1)),
               after = lattice_variance(lattice(0.0626, 0, 0, 1));
  EXPECT_NEAR(before / after, 626.0 / 624.0, 2e-3) << "both ways meet";
}

TEST(InterpolationNoise, PointsFarApartShareNothing) {
  const double one = interpolation_covariance(0.0);
  EXPECT_NEAR(lattice_variance(lattice(5, 0, 0, 5)), one * one, 1e-14);
  EXPECT_NEAR(lattice_variance(lattice(3, 3, -3, 3)), one * one, 2e-4) << "turned by 45 degrees";
  // rows that share nothing, of many points each
  EXPECT_NEAR(lattice_variance(lattice(0.01, 0, 0, 5)), 100.0 * one, 100.0 * 2e-4);
}

}  // namespace
}  // namespace fringetwin::study::interpolation_noise_test
