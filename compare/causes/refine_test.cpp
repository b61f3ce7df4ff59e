// SPDX-License-Identifier: Apache-2.0
// A refinement never leaves a twin that fits worse than the one it began with.
#include "compare/causes/refine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fringetwin::compare::refine_test {
namespace {

Twin ball_at(double x_mm) {
  Twin twin;
  twin.objects = {{"ball", SphereShape{{x_mm, 0, 270}, 19}, {}}};
  return twin;
}

Refined refined_to(double x_mm, double chi2_before, double chi2_after) {
  Refined refined{ball_at(x_mm), {}};
  refined.report.rows = {{"ball.center_mm.x", "mm", 5.0, x_mm, 0.01}};
  refined.report.chi2_before = chi2_before;
  refined.report.chi2_after = chi2_after;
  return refined;
}

double x_mm(const Refined& refined) {
  return std::get<SphereShape>(refined.twin.objects[0].shape).center_mm.x();
}

TEST(Refine, AWorseTwinIsTakenBackAndSaidSo) {
  Refined worse = refined_to(7.0, 1.25, 1.5);
  keep_the_better(worse, ball_at(5.0));
  EXPECT_EQ(x_mm(worse), 5.0);
  EXPECT_EQ(worse.report.rows[0].after, 5.0);
  EXPECT_EQ(worse.report.chi2_after, 1.25);
  EXPECT_THAT(worse.report.notes, ::testing::ElementsAre(::testing::HasSubstr("rise from 1.25 to 1.5")));
}

TEST(Refine, ABetterTwinStays) {
  Refined better = refined_to(7.0, 1.5, 1.25);
  keep_the_better(better, ball_at(5.0));
  EXPECT_EQ(x_mm(better), 7.0);
  EXPECT_EQ(better.report.rows[0].after, 7.0);
  EXPECT_TRUE(better.report.notes.empty());
}

}  // namespace
}  // namespace fringetwin::compare::refine_test
