// SPDX-License-Identifier: Apache-2.0
// | check                                     | tolerance | unit  | origin |
// |-------------------------------------------|-----------|-------|------------------------------------------|
// | phase of an exact sinusoid                | 1e-6      | rad   | float: 3e-7 atan2 + 2^-24 mean/amplitude
// | | amplitude, mean                           | 1e-6      | of mean | float sums of 12 terms | |
// phase_variance against Monte Carlo        | 5         | %     | 20000 draws: 1 % sigma, 5 sigma          |
// | residual rms against the noise put in     | 2         | %     | 40000 px x (N-3) draws |
#include "measure/decode/phase.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::measure::phase_test {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

struct StepPhase {
  ImageF phase_rad, amplitude_dn, mean_dn, residual_dn;  ///< residual rms of the fit, NaN when 3 steps
};

/// Solves all pixels row by row. images[i] is phase step number steps_n[i] of steps_total.
StepPhase least_squares_phase(const std::vector<const ImageF*>& images, const std::vector<int>& steps_n,
                              int steps_total) {
  const StepSolver solver(steps_n, steps_total);
  const int w = images.front()->width, h = images.front()->height;
  StepPhase result{ImageF(w, h), ImageF(w, h), ImageF(w, h), ImageF(w, h)};
  for (int y = 0; y < h; ++y) {
    std::vector<const float*> rows;
    for (const ImageF* image : images) rows.push_back(&(*image)(0, y));
    solve_row(solver, rows.data(), w,
              {.phase_rad = &result.phase_rad(0, y),
               .amplitude = &result.amplitude_dn(0, y),
               .mean = &result.mean_dn(0, y),
               .residual = &result.residual_dn(0, y)});
  }
  return result;
}

struct Stack {
  std::vector<ImageF> images;
  std::vector<const ImageF*> pointers() const {
    std::vector<const ImageF*> p;
    for (const ImageF& i : images) p.push_back(&i);
    return p;
  }
};

/// One row whose pixel x has phase -pi + 2pi x/(n-1).
Stack sinusoids(const std::vector<int>& steps, int total, int n, double mean, double amplitude) {
  Stack s;
  for (const int k : steps) {
    s.images.emplace_back(n, 1);
    for (int x = 0; x < n; ++x) {
      const double phase = -std::numbers::pi + kTwoPi * x / (n - 1);
      s.images.back()(x, 0) = static_cast<float>(mean + amplitude * std::cos(phase + kTwoPi * k / total));
    }
  }
  return s;
}

std::vector<int> all_steps(int n) {
  std::vector<int> s(static_cast<std::size_t>(n));
  std::iota(s.begin(), s.end(), 0);
  return s;
}

double worst_phase_error(const std::vector<int>& steps, int total, double mean, double amplitude) {
  constexpr int kPixels = 4001;  // not a multiple of the kernel's block
  const Stack s = sinusoids(steps, total, kPixels, mean, amplitude);
  const StepPhase r = least_squares_phase(s.pointers(), steps, total);
  double worst = 0.0;
  for (int x = 0; x < kPixels; ++x) {
    const double truth = -std::numbers::pi + kTwoPi * x / (kPixels - 1);
    const auto phase = static_cast<double>(r.phase_rad(x, 0));
    EXPECT_GT(phase, -std::numbers::pi);
    EXPECT_LE(phase, std::numbers::pi);
    worst = std::max(worst, std::fabs(std::remainder(phase - truth, kTwoPi)));
    EXPECT_NEAR(static_cast<double>(r.amplitude_dn(x, 0)), amplitude, 1e-6 * mean);
    EXPECT_NEAR(static_cast<double>(r.mean_dn(x, 0)), mean, 1e-6 * mean);
  }
  return worst;
}

TEST(LeastSquaresPhase, FullSetsOfAnyLength) {
  for (int n = 3; n <= 24; ++n)
    EXPECT_LT(worst_phase_error(all_steps(n), n, 120.0, 100.0), 1e-6) << n << " steps";
}

RC_GTEST_PROP(LeastSquaresPhase, AnySubset, ()) {
  const int total = *rc::gen::inRange(3, 17);
  std::vector<int> steps = all_steps(total);
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  std::shuffle(steps.begin(), steps.end(), random);
  steps.resize(static_cast<std::size_t>(*rc::gen::inRange(3, total + 1)));
  // A few neighbouring steps of many see a short arc: the error grows with the phase's own variance.
  const StepSolver solver(steps, total);
  const double growth = std::sqrt(std::max(solver.phase_variance(1.0, 0.0), solver.phase_variance(0.0, 1.0)));
  RC_ASSERT(worst_phase_error(steps, total, 120.0, 100.0) < 1e-6 * (1.0 + growth * growth));
}

TEST(LeastSquaresPhase, WeightsOfTheFullSetAreTheClosedForm) {
  for (const int n : {3, 4, 5, 12}) {
    const StepSolver s(all_steps(n), n);
    EXPECT_TRUE(s.isotropic());
    EXPECT_NEAR(s.phase_variance(0.6, 0.8), 2.0 / n, 1e-12);
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_FLOAT_EQ(s.mean_weights()[k], static_cast<float>(1.0 / n));
      EXPECT_NEAR(static_cast<double>(s.cos_weights()[k]), 2.0 / n * std::cos(kTwoPi * i / n), 1e-7);
      EXPECT_NEAR(static_cast<double>(s.sin_weights()[k]), -2.0 / n * std::sin(kTwoPi * i / n), 1e-7);
    }
  }
}

TEST(LeastSquaresPhase, PredictedVarianceOfSubsetsMatchesDraws) {
  constexpr int kDraws = 20000;
  const std::vector<std::vector<int>> subsets = {
      {0, 1, 2}, {0, 2, 3, 7}, {0, 2, 4, 6, 8, 10}, {1, 2, 3, 4, 5}};
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (const auto& steps : subsets)
    for (const double phase : {0.3, 1.2, 2.9}) {
      Stack s;
      for (const int k : steps) {
        s.images.emplace_back(kDraws, 1);
        for (float& v : s.images.back().data)
          v = static_cast<float>(120.0 + 100.0 * std::cos(phase + kTwoPi * k / 12) + 0.5 * normal(random));
      }
      const StepPhase r = least_squares_phase(s.pointers(), steps, 12);
      double sum = 0.0;
      for (const float p : r.phase_rad.data)
        sum += (static_cast<double>(p) - phase) * (static_cast<double>(p) - phase);
      const double predicted =
          StepSolver(steps, 12).phase_variance(std::cos(phase), std::sin(phase)) * 0.25 / 1e4;
      EXPECT_NEAR(sum / kDraws / predicted, 1.0, 0.05) << steps.size() << " steps at " << phase;
    }
}

TEST(LeastSquaresPhase, ResidualEstimatesTheNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 2.0);
  for (const int n : {4, 5, 12}) {
    Stack s = sinusoids(all_steps(n), n, 40000, 120.0, 90.0);
    for (ImageF& image : s.images)
      for (float& v : image.data) v += static_cast<float>(normal(random));
    const StepPhase r = least_squares_phase(s.pointers(), all_steps(n), n);
    double sum = 0.0;
    for (const float v : r.residual_dn.data) sum += static_cast<double>(v) * static_cast<double>(v);
    EXPECT_NEAR(std::sqrt(sum / 40000.0), 2.0, 0.04) << n << " steps";
  }
}

TEST(LeastSquaresPhase, ThreeStepsHaveNoResidual) {
  const Stack s = sinusoids({0, 1, 2}, 3, 5, 120.0, 90.0);
  for (const float v : least_squares_phase(s.pointers(), {0, 1, 2}, 3).residual_dn.data)
    EXPECT_TRUE(std::isnan(v));
}

TEST(LeastSquaresPhase, QuadrantsAndZeroModulation) {
  // Four steps: c = (I0 - I2)/2, s = (I3 - I1)/2.
  const auto phase = [](float i0, float i1, float i2, float i3) {
    const ImageF a(1, 1, i0), b(1, 1, i1), c(1, 1, i2), d(1, 1, i3);
    return least_squares_phase({&a, &b, &c, &d}, {0, 1, 2, 3}, 4).phase_rad(0, 0);
  };
  EXPECT_NEAR(phase(2, 1, 0, 1), 0.0, 1e-6);
  EXPECT_NEAR(phase(1, 0, 1, 2), std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(phase(1, 2, 1, 0), -std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(phase(0, 1, 2, 1), std::numbers::pi, 1e-6);  // +pi, never -pi
  EXPECT_TRUE(std::isfinite(phase(7, 7, 7, 7)));
}

TEST(LeastSquaresPhase, RefusesTooFewOrDoubleSteps) {
  EXPECT_THROW(StepSolver({0, 1}, 4), UserError);
  EXPECT_THROW(StepSolver({0, 1, 1}, 4), UserError);
  EXPECT_THROW(StepSolver({0, 1, 4}, 4), UserError);
  EXPECT_THROW(StepSolver({-1, 0, 1}, 4), UserError);
}

}  // namespace
}  // namespace fringetwin::measure::phase_test
