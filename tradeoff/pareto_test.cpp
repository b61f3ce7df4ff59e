// SPDX-License-Identifier: Apache-2.0
// No tolerances: marks and counts.
#include "tradeoff/pareto.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fringetwin::tradeoff::pareto_test {
namespace {

TEST(ParetoFront, MarksEachPairOfQuantitiesByItself) {
  std::vector<ParetoPoint> points(3);
  const auto fill = [](ParetoPoint& p, double ms, double rad, double dn, double s, double mm) {
    p.frame_ms = ms;
    p.error.phase_interior_rms_rad = rad;
    p.error.gray_rms_dn = dn;
    p.chain_s = s;
    p.fit_shift_mm = mm;
  };
  fill(points[0], 1, 3, 1, 1, std::nan(""));
  fill(points[1], 2, 2, 2, 3, 1e-3);
  fill(points[2], 3, 1, 3, 2, 1e-3);
  mark_fronts(points);
  EXPECT_TRUE(points[0].on_phase_front && points[1].on_phase_front && points[2].on_phase_front);
  EXPECT_TRUE(points[0].on_gray_front && !points[1].on_gray_front && !points[2].on_gray_front);
  EXPECT_TRUE(!points[0].on_fit_front && !points[1].on_fit_front && points[2].on_fit_front);
  points[2].is_fit_reference = true;
  points[2].on_fit_front = false;
  mark_fronts(points);
  EXPECT_TRUE(points[1].on_fit_front && !points[2].on_fit_front) << "a shift against itself is no error of 0";
}

ParetoPoint point(Sampler sampler, const std::string& family, int samples, bool precise, double ms = kNaN,
                  double cpu_ms = kNaN) {
  ParetoPoint p;
  p.scheme.family = family;
  p.scheme.sampling.sampler = sampler;
  p.scheme.sampling.samples = samples;
  p.scheme.sampling.precise = precise;
  p.frame_ms = ms, p.frame_cpu_ms = cpu_ms;
  return p;
}

// 64 samples take 4 times the time of 16 of the same family and precision, and never what others take. All
// ratios are powers of two: exact.
TEST(PredictedTime, GrowsWithTheSamplesOfTheLargestMeasuredOfItsFamily) {
  std::vector<ParetoPoint> points{point(Sampler::gauss, "gauss", 4, false, 5.0, 9.0),
                                  point(Sampler::gauss, "gauss", 16, false, 18.0, 30.0),
                                  point(Sampler::gauss, "gauss", 64, false),
                                  point(Sampler::gauss, "gauss", 64, true),
                                  point(Sampler::gauss, "gauss", 32, true, 100.0, 300.0),
                                  point(Sampler::sobol, "sobol", 1024, false, 700.0, 900.0),
                                  point(Sampler::multi_jittered, "multi-jittered", 64, false)};
  const auto predicted = predict_time(points, points[2]);
  ASSERT_TRUE(predicted);
  EXPECT_EQ(predicted->frame_ms, 72.0);
  EXPECT_EQ(predicted->frame_cpu_ms, 120.0);
  EXPECT_EQ(predicted->from_samples, 16);
  EXPECT_FALSE(predict_time(points, points[6])) << "of its family nothing was measured";

  extrapolate_times(points);
  EXPECT_EQ(points[1].frame_ms, 18.0) << "measured";
  EXPECT_EQ(points[1].extrapolated_from, 0);
  EXPECT_EQ(points[2].frame_ms, 72.0);
  EXPECT_EQ(points[2].frame_cpu_ms, 120.0);
  EXPECT_EQ(points[2].extrapolated_from, 16);
  EXPECT_EQ(points[3].frame_ms, 200.0) << "double precision, from double precision";
  EXPECT_EQ(points[3].frame_cpu_ms, 600.0);
  EXPECT_EQ(points[3].extrapolated_from, 32);
  EXPECT_TRUE(std::isnan(points[6].frame_ms));
  EXPECT_EQ(points[6].extrapolated_from, 0);
}

TEST(PredictedTime, IsNotTakenFromAPrediction) {
  std::vector<ParetoPoint> points{point(Sampler::sobol, "sobol", 4, false, 3.0, 5.0),
                                  point(Sampler::sobol, "sobol", 16, false, 1e6, 1e6),
                                  point(Sampler::sobol, "sobol", 32, false)};
  points[1].extrapolated_from = 4;
  EXPECT_EQ(predict_time(points, points[2])->frame_ms, 24.0);
}

// What adaptive sampling takes is not in its number of samples.
TEST(PredictedTime, OfAdaptiveSamplingIsWhatAnotherTargetTook) {
  std::vector<ParetoPoint> points{point(Sampler::adaptive, "adaptive", 8, false, 40.0, 70.0),
                                  point(Sampler::adaptive, "adaptive", 1, false)};
  EXPECT_EQ(predict_time(points, points[1])->frame_ms, 40.0);
}

// The published scheme is there, the default is marked exactly once, whatever it is.
TEST(SchemeTable, HoldsTheDefaultAndThePublishedScheme) {
  Twin twin;
  for (const auto samples : {std::optional<int>{}, std::optional<int>{25}, std::optional<int>{1000}}) {
    twin.render.samples = samples;
    for (const bool quick : {false, true}) {
      int n_default = 0, n_published = 0;
      for (const Scheme& s : scheme_table(twin, true, quick)) {
        n_default += s.is_default;
        n_published += s.is_published;
      }
      EXPECT_EQ(n_default, 1);
      EXPECT_EQ(n_published, quick ? 0 : 1);
    }
  }
}

}  // namespace
}  // namespace fringetwin::tradeoff::pareto_test
