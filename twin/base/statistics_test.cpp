// SPDX-License-Identifier: Apache-2.0
#include "twin/base/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace fringetwin::statistics_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();

TEST(Statistics, TheMedianOfAnEvenNumberIsNamed) {
  std::vector<double> odd{9.0, 1.0, 4.0}, even{9.0, 1.0, 4.0, 5.0}, same = even;
  EXPECT_EQ(median(odd), 4.0);
  EXPECT_EQ(upper_median(odd), 4.0);
  EXPECT_EQ(median(even), 4.5);
  EXPECT_EQ(upper_median(same), 5.0);
  std::vector<float> single{7.5F};
  EXPECT_EQ(upper_median(single), 7.5);
}

TEST(Statistics, QuantilesInterpolateOrTakeTheValueBelow) {
  std::vector<float> v{40.0F, 10.0F, 30.0F, 20.0F};
  EXPECT_EQ(quantile(v, 0.0), 10.0);
  EXPECT_EQ(quantile(v, 0.5), 25.0);
  EXPECT_EQ(quantile(v, 0.25), 17.5);
  EXPECT_EQ(quantile(v, 1.0), 40.0);
  EXPECT_EQ(lower_quantile(v, 0.5), 20.0);
  EXPECT_EQ(lower_quantile(v, 0.999), 30.0);
  EXPECT_EQ(lower_quantile(v, 1.0), 40.0);
  std::vector<double> d{3.0, 2.0, 1.0};
  EXPECT_EQ(lower_quantile(d, 0.95), 2.0);
}

TEST(Statistics, RanksCountFromZero) {
  std::vector<std::uint16_t> v{500, 3, 70};
  EXPECT_EQ(nth_smallest(v, 0), 3.0);
  EXPECT_EQ(nth_smallest(v, 2), 500.0);
  EXPECT_TRUE(std::isnan(nth_smallest(v, 3)));
}

TEST(Statistics, TheRobustScaleIgnoresSignsAndOutliers) {
  std::vector<double> r{-1.0, 2.0, -3.0, 1e9, 0.5};
  EXPECT_EQ(mad_sigma(r), 1.4826 * 2.0);
}

TEST(Statistics, NanIsLeftOutAndInfinityCounts) {
  const double inf = std::numeric_limits<double>::infinity();
  std::vector<double> v{kNan, 5.0, inf, kNan, 1.0};
  EXPECT_EQ(upper_median(v), 5.0);
  EXPECT_EQ(median(v), 5.0);
  EXPECT_EQ(lower_quantile(v, 1.0), inf);
  EXPECT_EQ(mad_sigma(v), 1.4826 * 5.0);
  EXPECT_EQ(nth_smallest(v, 0), 1.0);
  EXPECT_TRUE(std::isnan(nth_smallest(v, 3)));
  std::vector<float> f{2.0F, kNanF, 1.0F};
  EXPECT_EQ(quantile(f, 0.5), 1.5);
}

TEST(Statistics, NoValueGivesNan) {
  std::vector<double> none, unknown{kNan, kNan};
  std::vector<float> none_f;
  EXPECT_TRUE(std::isnan(median(none)));
  EXPECT_TRUE(std::isnan(median(unknown)));
  EXPECT_TRUE(std::isnan(upper_median(unknown)));
  EXPECT_TRUE(std::isnan(mad_sigma(none)));
  EXPECT_TRUE(std::isnan(quantile(none_f, 0.5)));
  EXPECT_TRUE(std::isnan(lower_quantile(none, 0.5)));
}

TEST(Statistics, ValuesWithoutNanKeepTheOrderThatTheSearchGivesThem) {
  // sums over the values afterwards depend on it (calib/photometry/photon_transfer.cpp)
  std::vector<float> a, b;
  for (int i = 0; i < 1000; ++i) a.push_back(static_cast<float>((i * 7919) % 1009));
  b = a;
  upper_median(a);
  std::nth_element(b.begin(), b.begin() + 500, b.end());
  EXPECT_EQ(a, b);
}

}  // namespace
}  // namespace fringetwin::statistics_test
