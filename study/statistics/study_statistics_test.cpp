// SPDX-License-Identifier: Apache-2.0
// tolerance: quantiles to the digits of the published tables, sums to rounding (1e-12 of the values).
#include "study/statistics/study_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fringetwin::study::study_statistics_test {
namespace {

TEST(StudyStatistics, QuantilesOfThePublishedTables) {
  // NIST/SEMATECH e-Handbook, 1.3.6.7.2 and 1.3.6.7.4
  EXPECT_NEAR(student_t_quantile(0.975, 1), 12.706, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.975, 3), 3.182, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.95, 10), 1.812, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.025, 10), -2.228, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.975, 3), 9.348, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.025, 3), 0.216, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.95, 10), 18.307, 5e-4);
}

TEST(StudyStatistics, FourSeedsOfOneSettingByHand) {
  const SettingRuns runs = {{1, 2.0}, {2, 4.0}, {3, 4.0}, {4, 6.0}};  // mean 4, s^2 = 8/3
  const GroupStatistics g = group_statistics({&runs}, 0.95);
  EXPECT_EQ(g.runs, 4u);
  EXPECT_EQ(g.seeds, 4u);
  EXPECT_DOUBLE_EQ(g.mean, 4.0);
  EXPECT_NEAR(g.sigma, std::sqrt(8.0 / 3.0), 1e-12);
  EXPECT_NEAR(g.rms, std::sqrt(72.0 / 4.0), 1e-12);
  EXPECT_NEAR(g.mean_band.high - 4.0, 3.182 * std::sqrt(8.0 / 3.0 / 4.0), 1e-3);
  EXPECT_NEAR(4.0 - g.mean_band.low, g.mean_band.high - 4.0, 1e-12);
  EXPECT_NEAR(g.sigma_band.low, g.sigma * std::sqrt(3.0 / 9.348), 1e-4);
  EXPECT_NEAR(g.sigma_band.high, g.sigma * std::sqrt(3.0 / 0.2158), 1e-3);
  EXPECT_FALSE(g.band_of_settings);
  EXPECT_TRUE(std::isnan(g.between));  // of one setting
}

TEST(StudyStatistics, SettingsThatShareTheirNoiseAreNotAveragedAway) {
  // Three settings, offset by 10 and 20, with the same noise of each seed: the mean is known as of one.
  const SettingRuns a = {{1, -1.0}, {2, 0.0}, {3, 1.0}}, b = {{1, 9.0}, {2, 10.0}, {3, 11.0}},
                    c = {{1, 19.0}, {2, 20.0}, {3, 21.0}};
  const GroupStatistics one = group_statistics({&a}, 0.95), all = group_statistics({&a, &b, &c}, 0.95);
  EXPECT_NEAR(all.mean, 10.0, 1e-12);
  EXPECT_NEAR(all.mean_band.high - all.mean, one.mean_band.high - one.mean, 1e-12);
  EXPECT_NEAR(all.sigma, 1.0, 1e-12);
  EXPECT_NEAR(all.between, 10.0, 1e-12);
  // Noise that cancels between the settings leaves nothing.
  const SettingRuns opposite = {{1, 1.0}, {2, 0.0}, {3, -1.0}};
  const GroupStatistics none = group_statistics({&a, &opposite}, 0.95);
  EXPECT_NEAR(none.mean_band.high, none.mean, 1e-12);
  EXPECT_NEAR(none.sigma, 1.0, 1e-12);
}

TEST(StudyStatistics, OneSeedLeavesTheSpreadOfTheSettings) {
  const SettingRuns a = {{7, 1.0}}, b = {{7, 3.0}}, none;
  const GroupStatistics g = group_statistics({&a, &none, &b}, 0.95);
  EXPECT_EQ(g.settings, 2u);
  EXPECT_TRUE(g.band_of_settings);
  EXPECT_TRUE(std::isnan(g.sigma));
  EXPECT_NEAR(g.mean_band.high, 2.0 + 12.706 * 1.0, 1e-2);  // s/sqrt(2) = 1
  EXPECT_TRUE(std::isnan(group_statistics({&a}, 0.95).mean_band.low));
  EXPECT_TRUE(std::isnan(group_statistics({&none}, 0.95).mean));
}

/// 2000 samples of 5 normal values: both bands hold the truth in 95 % (standard error of the share: 0.5 %).
TEST(StudyStatistics, BandsHoldTheTruthAsOftenAsTheySay) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(7.0, 2.0);
  int mean_in = 0, sigma_in = 0;
  constexpr int n = 2000;
  for (int k = 0; k < n; ++k) {
    SettingRuns runs;
    for (std::uint64_t s = 0; s < 5; ++s) runs.push_back({s, noise(random)});
    const GroupStatistics g = group_statistics({&runs}, 0.95);
    mean_in += g.mean_band.low < 7.0 && 7.0 < g.mean_band.high;
    sigma_in += g.sigma_band.low < 2.0 && 2.0 < g.sigma_band.high;
  }
  EXPECT_NEAR(static_cast<double>(mean_in) / n, 0.95, 0.02);
  EXPECT_NEAR(static_cast<double>(sigma_in) / n, 0.95, 0.02);
}

TEST(StudyStatistics, RunningMeanOfALine) {
  std::vector<double> x, y;
  for (int i = 99; i >= 0; --i) x.push_back(i), y.push_back(3.0 * i);
  y[3] = std::nan("");
  const RunningMean m = running_mean(x, y, 0.95);
  ASSERT_EQ(m.x.size(), 9u);  // sqrt(99 points)
  for (std::size_t i = 0; i < m.x.size(); ++i) {
    EXPECT_NEAR(m.mean[i], 3.0 * m.x[i], 1e-9);
    EXPECT_LT(m.low[i], m.mean[i]);
  }
  EXPECT_TRUE(running_mean({1, 2, 3}, {1, 2, 3}, 0.95).x.empty());
}

// Three bins of four values -1, 1, -1, 1 each: sigma sqrt(4/3), of the mean half of that, times Student's t
// of three degrees of freedom.
TEST(StudyStatistics, RunningMeansBandIsOfTheMean) {
  std::vector<double> x, y;
  for (int i = 0; i < 12; ++i) x.push_back(i), y.push_back(i % 2 == 0 ? -1.0 : 1.0);
  const RunningMean m = running_mean(x, y, 0.95);
  ASSERT_EQ(m.mean.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(m.mean[i], 0.0, 1e-14);
    EXPECT_NEAR(m.high[i], 3.182446305 * std::sqrt(1.0 / 3.0), 1e-8);  // digits of the table
    EXPECT_NEAR(m.low[i], -m.high[i], 1e-14);
  }
}

}  // namespace
}  // namespace fringetwin::study::study_statistics_test
