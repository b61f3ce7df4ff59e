// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit  | origin                                                                     |
// |-----------|-------|----------------------------------------------------------------------------|
// | 1e-13     | x     | quantiles tabulated to 16 digits; rounding of erfc times x                 |
// | 1e-12     | u     | relative, of the tail: rounding of x = 8 changes it by 8 x 8 ulp           |
// | 5         | sigma | of a mean and a variance of 10^5 draws, fixed seed                         |
// | 1.95      | 1     | sqrt(n) times Kolmogorov's distance: exceeded by chance once in 1000 times |
#include "study/plan/random_draws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace fringetwin::study::random_draws_test {
namespace {

TEST(Draws, NormalQuantilesOfTheTables) {
  EXPECT_NEAR(normal_quantile(0.5), 0.0, 1e-13);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-13);
  EXPECT_NEAR(normal_quantile(0.995), 2.575829303548901, 1e-13);
  EXPECT_NEAR(normal_quantile(0.025), -1.959963984540054, 1e-13);
  EXPECT_NEAR(normal_quantile(1e-10), -6.361340902404056, 1e-13);
  EXPECT_NEAR(normal_quantile(1e-15), -7.941345326170997, 1e-13);
}

TEST(Draws, NormalQuantileIsTheInverseOfTheDistribution) {
  for (double tail = 0.5; tail > 1e-15; tail *= 0.7) {
    const double x = normal_quantile(tail);
    EXPECT_NEAR(0.5 * std::erfc(-x / std::sqrt(2.0)) / tail, 1.0, 1e-12) << tail;
  }
}

TEST(Draws, UniformWithinTheUnitInterval) {
  constexpr int n = 100'000;
  std::vector<double> u;
  double sum = 0.0, square = 0.0;
  for (int i = 0; i < n; ++i) {
    u.push_back(unit_draw(7, DrawStream::trials, static_cast<std::uint64_t>(i), 2));
    sum += u.back() - 0.5;
    square += (u.back() - 0.5) * (u.back() - 0.5);
  }
  EXPECT_NEAR(sum / n, 0.0, 5.0 * std::sqrt(1.0 / 12.0 / n));
  EXPECT_NEAR(square / n, 1.0 / 12.0, 5.0 * std::sqrt(1.0 / 180.0 / n));
  std::sort(u.begin(), u.end());
  double distance = 0.0;
  for (int i = 0; i < n; ++i)
    distance = std::max(distance, std::abs(u[static_cast<std::size_t>(i)] - (i + 0.5) / n));
  EXPECT_LT(std::sqrt(n) * distance, 1.95);
  EXPECT_GT(u.front(), 0.0);
  EXPECT_LT(u.back(), 1.0);
}

TEST(Draws, EveryPartOfTheAddressCounts) {
  std::set<std::uint64_t> seen;
  const std::uint64_t far = std::uint64_t{1} << 40;
  for (const std::uint64_t seed : {std::uint64_t{1}, std::uint64_t{2}, far})
    for (const DrawStream stream :
         {DrawStream::trials, DrawStream::sensitivity_a, DrawStream::sensitivity_b, DrawStream::bootstrap})
      for (const std::uint64_t trial : {std::uint64_t{0}, std::uint64_t{1}, far})
        for (const std::uint32_t dimension : {0u, 1u, 1000u})
          seen.insert(random_bits(seed, stream, trial, dimension));
  EXPECT_EQ(seen.size(), 3u * 4u * 3u * 3u);
  EXPECT_EQ(random_bits(1, DrawStream::trials, 5, 3), random_bits(1, DrawStream::trials, 5, 3));
}

}  // namespace
}  // namespace fringetwin::study::random_draws_test
