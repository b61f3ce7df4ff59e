// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit  | origin                                                                           |
// |-----------|-------|----------------------------------------------------------------------------------|
// | 5         | sigma | half the width of the bootstrap's 68.27 % interval, fixed seed                   |
// | 0.03      | 1     | widest such sigma allowed at 2^14 rows: the estimators scatter by 0.5 to 2 / sqrt N |
// | 0.90      | share | of 95 % intervals that hold the truth, 200 repeats: 4.6 % from chance (3 sigma)  |
#include "study/statistics/sobol_indices.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "study/plan/random_draws.hpp"

namespace fringetwin::study::sobol_indices_test {
namespace {

using Inputs = std::vector<double>;  ///< uniform in (0, 1)
using Model = std::function<double(const Inputs&)>;
using Groups = std::vector<std::vector<std::size_t>>;

constexpr double kOneSigma = 0.6826894921370859;

SobolSample saltelli(std::size_t rows, std::size_t inputs, const Groups& groups, std::uint64_t seed,
                     const Model& model) {
  SobolSample out;
  out.a_with_b.resize(groups.size());
  for (std::size_t i = 0; i < rows; ++i) {
    Inputs a, b;
    for (std::uint32_t d = 0; d < inputs; ++d) {
      a.push_back(unit_draw(seed, DrawStream::sensitivity_a, i, d));
      b.push_back(unit_draw(seed, DrawStream::sensitivity_b, i, d));
    }
    out.a.push_back(model(a));
    out.b.push_back(model(b));
    for (std::size_t f = 0; f < groups.size(); ++f) {
      Inputs mixed = a;
      for (const std::size_t d : groups[f]) mixed[d] = b[d];
      out.a_with_b[f].push_back(model(mixed));
    }
  }
  return out;
}

Groups each(std::size_t inputs) {
  Groups out;
  for (std::size_t i = 0; i < inputs; ++i) out.push_back({i});
  return out;
}

void expect_indices(const SobolIndices& found, const std::vector<double>& first,
                    const std::vector<double>& total) {
  const auto expect = [](const SobolIndex& index, double truth, const char* what, std::size_t factor) {
    const double sigma = 0.5 * (index.interval.high - index.interval.low);
    EXPECT_LT(sigma, 0.03) << what << factor;
    EXPECT_NEAR(index.value, truth, 5.0 * sigma) << what << factor;
  };
  ASSERT_EQ(found.first.size(), first.size());
  for (std::size_t f = 0; f < first.size(); ++f) {
    expect(found.first[f], first[f], "first ", f);
    expect(found.total[f], total[f], "total ", f);
  }
}

double ishigami(const Inputs& u) {
  const auto angle = [&](std::size_t i) { return std::numbers::pi * (2.0 * u[i] - 1.0); };
  return std::sin(angle(0)) + 7.0 * std::pow(std::sin(angle(1)), 2) +
         0.1 * std::pow(angle(2), 4) * std::sin(angle(0));
}

TEST(SobolIndices, LinearModelFarFromZero) {
  const std::vector<double> slopes = {3.0, 2.0, 1.0, 0.0};
  const Model model = [&](const Inputs& u) {
    double y = 1000.0;  // a radius in mm against its micrometres
    for (std::size_t i = 0; i < u.size(); ++i) y += slopes[i] * normal_quantile(u[i]);
    return y;
  };
  const auto found = sobol_indices(saltelli(1 << 12, 4, each(4), 1, model), kOneSigma, 1, 300);
  const std::vector<double> truth = {9.0 / 14.0, 4.0 / 14.0, 1.0 / 14.0, 0.0};
  expect_indices(found, truth, truth);
  EXPECT_NEAR(found.variance, 14.0, 5.0 * 14.0 / std::sqrt(4096.0));  // 2 N results
  EXPECT_EQ(found.total[3].value, 0.0) << "an input that has no part in the result";
}

TEST(SobolIndices, Ishigami) {
  // Variances of the parts, a = 7, b = 0.1 (Ishigami and Homma 1990).
  const double pi4 = std::pow(std::numbers::pi, 4), a = 7.0, b = 0.1;
  const double v1 = 0.5 * std::pow(1.0 + b * pi4 / 5.0, 2), v2 = a * a / 8.0,
               v13 = b * b * pi4 * pi4 * 8.0 / 225.0;
  const double v = v1 + v2 + v13;
  EXPECT_NEAR(v1 / v, 0.3139, 5e-5) << "the published value";
  const auto found = sobol_indices(saltelli(1 << 14, 3, each(3), 2, ishigami), kOneSigma, 1, 300);
  expect_indices(found, {v1 / v, v2 / v, 0.0}, {(v1 + v13) / v, v2 / v, v13 / v});
}

TEST(SobolIndices, GFunction) {
  const std::vector<double> a = {0.0, 1.0, 4.5, 9.0, 99.0, 99.0};
  const Model model = [&](const Inputs& u) {
    double y = 1.0;
    for (std::size_t i = 0; i < a.size(); ++i) y *= (std::abs(4.0 * u[i] - 2.0) + a[i]) / (1.0 + a[i]);
    return y;
  };
  double product = 1.0;
  std::vector<double> part, first, total;
  for (const double ai : a) part.push_back(1.0 / (3.0 * (1.0 + ai) * (1.0 + ai)));
  for (const double p : part) product *= 1.0 + p;
  for (const double p : part) {
    first.push_back(p / (product - 1.0));
    total.push_back(p * product / (1.0 + p) / (product - 1.0));
  }
  const auto found = sobol_indices(saltelli(1 << 14, 6, each(6), 3, model), kOneSigma, 1, 300);
  expect_indices(found, first, total);
}

TEST(SobolIndices, GroupOfInputsIsOneFactor) {
  // x1 and x3 of Ishigami together: all that is not x2.
  const auto found = sobol_indices(saltelli(1 << 14, 3, {{0, 2}, {1}}, 4, ishigami), kOneSigma, 1, 300);
  const double pi4 = std::pow(std::numbers::pi, 4);
  const double v2 = 49.0 / 8.0,
               v13 = 0.5 * std::pow(1.0 + 0.1 * pi4 / 5.0, 2) + 0.01 * pi4 * pi4 * 8.0 / 225.0;
  const double share = v13 / (v2 + v13);
  expect_indices(found, {share, 1.0 - share}, {share, 1.0 - share});
}

TEST(SobolIndices, BootstrapIntervalsHoldTheTruth) {
  const Model model = [](const Inputs& u) { return 2.0 * u[0] + u[1]; };
  int first = 0, total = 0;
  constexpr int repeats = 200;
  for (int r = 0; r < repeats; ++r) {
    const auto found = sobol_indices(saltelli(200, 2, each(2), 100 + static_cast<std::uint64_t>(r), model),
                                     0.95, static_cast<std::uint64_t>(r), 400);
    const auto holds = [](const SobolIndex& i) { return i.interval.low <= 0.8 && 0.8 <= i.interval.high; };
    first += holds(found.first[0]);
    total += holds(found.total[0]);
  }
  EXPECT_GE(first, static_cast<int>(0.90 * repeats));
  EXPECT_GE(total, static_cast<int>(0.90 * repeats));
}

TEST(SobolIndices, IncompleteRowsAndConstants) {
  SobolSample s = saltelli(500, 2, each(2), 5, [](const Inputs& u) { return u[0]; });
  const SobolSample whole = s;
  s.a.push_back(1e6);
  s.b.push_back(0.5);
  s.a_with_b[0].push_back(std::numeric_limits<double>::quiet_NaN());
  s.a_with_b[1].push_back(0.5);
  EXPECT_EQ(sobol_indices(s, 0.95, 1, 100).rows, 500u);
  EXPECT_EQ(sobol_indices(s, 0.95, 1, 100).first[0].value, sobol_indices(whole, 0.95, 1, 100).first[0].value);
  const auto constant =
      sobol_indices(saltelli(50, 2, each(2), 6, [](const Inputs&) { return 0.1; }), 0.95, 1, 100);
  EXPECT_EQ(constant.variance, 0.0);
  EXPECT_TRUE(std::isnan(constant.first[0].value));
  EXPECT_TRUE(std::isnan(constant.total[1].interval.high));
}

}  // namespace
}  // namespace fringetwin::study::sobol_indices_test
