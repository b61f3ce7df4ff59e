// SPDX-License-Identifier: Apache-2.0
// The examples of JCGM 101:2008 clause 9 and their closed forms.
// | tolerance | unit  | origin                                                                            |
// |-----------|-------|-----------------------------------------------------------------------------------|
// | 5         | sigma | of an average, a standard deviation, a quantile of the n draws, fixed seed        |
// | 0.0004    | mg    | mass: published digits (5e-5) and 5 sigma of a mean and a sigma of 10^6 draws     |
// | 0.0015    | mg    | mass: ends of the interval, 5 sigma of a quantile of 10^6 draws and half a digit  |
// | 0.85      | share | of adaptive stops whose true error is within the tolerance: 2 s of all four       |
// |           |       | numbers over few blocks is a small sample's estimate; measured 1                  |
#include "study/statistics/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "study/plan/random_draws.hpp"

namespace fringetwin::study::monte_carlo_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double uniform(std::uint64_t seed, std::size_t trial, std::uint32_t dimension) {
  return unit_draw(seed, DrawStream::trials, trial, dimension);
}
double normal(std::uint64_t seed, std::size_t trial, std::uint32_t dimension) {
  return normal_quantile(uniform(seed, trial, dimension));
}
/// Uniform of standard deviation 1.
double rectangular(std::uint64_t seed, std::size_t trial, std::uint32_t dimension) {
  return std::sqrt(3.0) * (2.0 * uniform(seed, trial, dimension) - 1.0);
}

template <class Model>
std::vector<double> draw(std::size_t n, const Model& model) {
  std::vector<double> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(model(i));
  return out;
}

/// 5 standard errors of the quantile of n draws below which a share of `tail` lies, at that density.
double quantile_error(std::size_t n, double tail, double density) {
  return 5.0 * std::sqrt(tail * (1.0 - tail) / static_cast<double>(n)) / density;
}

std::vector<double> counting(std::size_t n) {
  std::vector<double> v(n);
  std::iota(v.begin(), v.end(), 1.0);
  return v;
}

TEST(MonteCarlo, IntervalsCountAsTheStandardSays) {
  // M = 100, p = 0.95: q = 95, r = (100 - 95 + 1)/2 = 3.
  EXPECT_EQ(symmetric_interval(counting(100), 0.95).low, 3.0);
  EXPECT_EQ(symmetric_interval(counting(100), 0.95).high, 98.0);
  // M = 1000: q = 950, r = 25.
  EXPECT_EQ(symmetric_interval(counting(1000), 0.95).low, 25.0);
  EXPECT_EQ(symmetric_interval(counting(1000), 0.95).high, 975.0);
  // M = 30: p M = 28.5, q = 29, r = 1.
  EXPECT_EQ(symmetric_interval(counting(30), 0.95).low, 1.0);
  EXPECT_EQ(symmetric_interval(counting(30), 0.95).high, 30.0);
  std::vector<double> skew = counting(100);
  for (double& v : skew) v *= v;
  EXPECT_EQ(shortest_interval(skew, 0.95).low, 1.0);
  EXPECT_EQ(shortest_interval(skew, 0.95).high, 96.0 * 96.0);
}

TEST(MonteCarlo, TolerancesOfTheStandard) {
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.00035, 2), 0.000005);
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.00035, 1), 0.00005);
  EXPECT_DOUBLE_EQ(numerical_tolerance(2.0, 1), 0.5);
  EXPECT_DOUBLE_EQ(numerical_tolerance(35.0, 2), 0.5);
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.0999, 2), 0.005) << "0.0999 is 0.10 to two digits";
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.0994, 2), 0.0005);
  EXPECT_EQ(AdaptiveRule{}.trials_per_block(), 10'000u);
  EXPECT_EQ((AdaptiveRule{.coverage = 0.999}.trials_per_block()), 100'000u);
}

TEST(MonteCarlo, SumOfFourNormals) {  // 9.2.2: u = 2, interval +-3.92
  constexpr std::size_t n = 100'000;
  const auto s =
      summarise(draw(n,
                     [](std::size_t i) {
                       return normal(1, i, 0) + normal(1, i, 1) + normal(1, i, 2) + normal(1, i, 3);
                     }),
                0.95);
  const double k = 1.959963984540054, density = std::exp(-0.5 * k * k) / std::sqrt(8.0 * std::numbers::pi);
  EXPECT_EQ(s.n, n);
  EXPECT_NEAR(s.mean, 0.0, 5.0 * 2.0 / std::sqrt(n));
  EXPECT_NEAR(s.sigma, 2.0, 5.0 * 2.0 / std::sqrt(2.0 * n));
  EXPECT_NEAR(s.symmetric.low, -2.0 * k, quantile_error(n, 0.025, density));
  EXPECT_NEAR(s.symmetric.high, 2.0 * k, quantile_error(n, 0.025, density));
  EXPECT_LE(s.shortest.high - s.shortest.low, s.symmetric.high - s.symmetric.low);
}

TEST(MonteCarlo, SumOfFourRectangularInputsIsNarrowerThanTheNormal) {  // 9.2.3: +-3.88
  constexpr std::size_t n = 100'000;
  const auto s = summarise(draw(n,
                                [](std::size_t i) {
                                  return rectangular(2, i, 0) + rectangular(2, i, 1) + rectangular(2, i, 2) +
                                         rectangular(2, i, 3);
                                }),
                           0.95);
  // Irwin-Hall: the tail beyond t units (of 2 sqrt 3) from the end is t^4/24, its density t^3/6.
  const double t = std::pow(24.0 * 0.025, 0.25), unit = 2.0 * std::sqrt(3.0);
  const double end = unit * (2.0 - t);
  EXPECT_NEAR(end, 3.88, 0.005) << "the published value";
  EXPECT_NEAR(s.symmetric.high, end, quantile_error(n, 0.025, t * t * t / 6.0 / unit));
  EXPECT_NEAR(s.symmetric.low, -end, quantile_error(n, 0.025, t * t * t / 6.0 / unit));
}

TEST(MonteCarlo, MassCalibration) {  // 9.3: linear propagation gives u = 0.0539 mg, and is wrong
  const auto s = summarise(draw(1'000'000,
                                [](std::size_t i) {
                                  const double reference_mg = 100'000.0 + 0.050 * normal(3, i, 0);
                                  const double added_mg = 1.234 + 0.020 * normal(3, i, 1);
                                  const double air = 1.10 + 0.20 * uniform(3, i, 2);
                                  const double density = 7000.0 + 2000.0 * uniform(3, i, 3);
                                  const double density_reference = 7950.0 + 100.0 * uniform(3, i, 4);
                                  return (reference_mg + added_mg) *
                                             (1.0 + (air - 1.2) * (1.0 / density - 1.0 / density_reference)) -
                                         100'000.0;
                                }),
                           0.95);
  EXPECT_NEAR(s.mean, 1.2341, 0.0004);
  EXPECT_NEAR(s.sigma, 0.0754, 0.0004);
  EXPECT_NEAR(s.shortest.low, 1.0834, 0.0015);
  EXPECT_NEAR(s.shortest.high, 1.3825, 0.0015);
}

TEST(MonteCarlo, ComparisonLossWhereTheLinearSigmaIsZero) {  // 9.4, x1 = x2 = 0, u = 0.005
  constexpr std::size_t n = 100'000;
  const auto s =
      summarise(draw(n,
                     [](std::size_t i) {
                       return std::pow(0.005 * normal(4, i, 0), 2) + std::pow(0.005 * normal(4, i, 1), 2);
                     }),
                0.95);
  // Exponential of mean m = 2 u^2; density at a quantile of upper tail p is p/m.
  const double m = 2.0 * 0.005 * 0.005;
  EXPECT_NEAR(s.mean, m, 5.0 * m / std::sqrt(n));
  EXPECT_NEAR(s.sigma, m, 5.0 * m * std::sqrt(2.0 / n));  // kurtosis 9
  EXPECT_NEAR(s.symmetric.low, -m * std::log(0.975), quantile_error(n, 0.025, 0.975 / m));
  EXPECT_NEAR(s.symmetric.high, -m * std::log(0.025), quantile_error(n, 0.025, 0.025 / m));
  EXPECT_NEAR(s.shortest.low, 0.0, quantile_error(n, 0.05, 0.05 / m) / 10.0);
  EXPECT_NEAR(s.shortest.high, m * std::log(20.0), quantile_error(n, 0.05, 0.05 / m));
}

TEST(MonteCarlo, MissingResultsAreLeftOut) {
  const auto s = summarise({1.0, kNan, 3.0, kNan}, 0.95);
  EXPECT_EQ(s.n, 2u);
  EXPECT_EQ(s.mean, 2.0);
  EXPECT_DOUBLE_EQ(s.sigma, std::sqrt(2.0));
  EXPECT_TRUE(std::isnan(summarise({kNan, 1.0}, 0.95).sigma));
}

/// Trials until the rule is met, the way a study runs.
struct Stop {
  std::size_t trials = 0;
  SampleSummary summary;
  double tolerance = 0.0;
};
Stop run_until_converged(std::uint64_t seed, const AdaptiveRule& rule) {
  std::vector<double> trials;
  for (std::size_t block = 0; block < 2000; ++block) {
    for (std::size_t i = 0; i < rule.trials_per_block(); ++i)
      trials.push_back(3.0 + 2.0 * normal(seed, trials.size(), 0));
    const Convergence c = convergence(trials, rule);
    if (c.reached) return {trials.size(), summarise(trials, rule.coverage), c.tolerance};
  }
  return {};
}

TEST(MonteCarlo, AdaptiveStopOfTheStandard) {
  const AdaptiveRule rule;
  const Stop stop = run_until_converged(5, rule);
  ASSERT_GT(stop.trials, 0u);
  EXPECT_EQ(stop.tolerance, 0.05);  // u = 2.0
  // 2 s of an interval's end, s = 2 x 2.67/sqrt(M), is below 0.05 from M = 46,000 on; s is estimated from few
  // blocks.
  EXPECT_GE(stop.trials, 20'000u);
  EXPECT_LE(stop.trials, 200'000u);
  EXPECT_NEAR(stop.summary.sigma, 2.0, 0.05);
}

TEST(MonteCarlo, AdaptiveStopKeepsItsTolerance) {
  const AdaptiveRule rule{.digits = 1, .block_trials = 100, .least_blocks = 5};
  int kept = 0;
  constexpr int runs = 200;
  for (int seed = 0; seed < runs; ++seed) {
    const Stop stop = run_until_converged(1000 + static_cast<std::uint64_t>(seed), rule);
    ASSERT_GE(stop.trials, 500u);
    kept += std::abs(stop.summary.sigma - 2.0) <= stop.tolerance &&
            std::abs(stop.summary.mean - 3.0) <= stop.tolerance;
  }
  EXPECT_GE(kept, static_cast<int>(0.85 * runs));
  RecordProperty("kept", kept);
}

// JCGM 101, 7.9.4: twice the standard deviation of the average over the blocks. Of two blocks that lie d
// apart that is 2 (d/sqrt 2)/sqrt 2 = d; of three at 0, d, 2 d it is 2 d/sqrt 3.
TEST(MonteCarlo, ConvergenceIsTwiceTheStandardDeviationOfTheAverage) {
  const AdaptiveRule rule{.digits = 1, .block_trials = 100, .least_blocks = 2};
  constexpr double d = 0.25;  // without rounding
  std::vector<double> trials;
  const auto add_block = [&](double by) {
    for (const double v : counting(100)) trials.push_back(v + by);
  };
  add_block(0.0);
  add_block(d);
  const Convergence two = convergence(trials, rule);
  EXPECT_DOUBLE_EQ(two.mean, d);
  EXPECT_DOUBLE_EQ(two.low, d);
  EXPECT_DOUBLE_EQ(two.high, d);
  EXPECT_NEAR(two.sigma, 0.0, 1e-13) << "the blocks scatter alike";
  add_block(2.0 * d);
  const Convergence three = convergence(trials, rule);
  EXPECT_DOUBLE_EQ(three.mean, 2.0 * d / std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(three.high, 2.0 * d / std::sqrt(3.0));
  EXPECT_EQ(three.tolerance, 5.0) << "1 ... 100 have sigma 29, one digit of which is right to 5";
}

TEST(MonteCarlo, ConvergenceOfCornerCases) {
  const AdaptiveRule rule{.digits = 1, .block_trials = 10, .least_blocks = 2};
  EXPECT_FALSE(convergence(std::vector<double>(19, 1.0), rule).reached) << "one block";
  EXPECT_TRUE(convergence(std::vector<double>(20, 0.1), rule).reached) << "a constant";
  std::vector<double> lost(20, 1.0);
  std::fill(lost.begin() + 10, lost.end(), kNan);
  EXPECT_FALSE(convergence(lost, rule).reached) << "a block without results";
  std::vector<double> apart(20, 1.0);
  std::fill(apart.begin() + 10, apart.end(), 2.0);
  EXPECT_FALSE(convergence(apart, rule).reached) << "two blocks that differ by as much as all spread";
}

}  // namespace
}  // namespace fringetwin::study::monte_carlo_test
