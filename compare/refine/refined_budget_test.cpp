// SPDX-License-Identifier: Apache-2.0
// What the standard errors of refined places leave uncertain: the changed twins add up to the covariance, and
// what they explain is excused, nothing else. Rendered budgets: compare/verdict/rig_budget_test.cpp.
#include "compare/refine/refined_budget.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "compare/parameters/parameters.hpp"
#include "compare/refine/refine_guard.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare::refined_budget_test {
namespace {

Twin ball_at(const Eigen::Vector3d& center_mm) {
  Twin twin;
  twin.objects = {{"ball", SphereShape{center_mm, 19}, {}}};
  return twin;
}

Eigen::Vector3d center_of(const Twin& twin) { return std::get<SphereShape>(twin.objects[0].shape).center_mm; }

TEST(OneErrorAway, AddsUpToTheCovarianceAboutTheFittedTwin) {
  const std::vector<Parameter> places = parameters_of(ball_at({0, 0, 270}), "pose");
  ASSERT_EQ(places.size(), 3u);
  const Eigen::Vector3d fitted(0.2, -0.1, 271);
  Eigen::Matrix3d covariance;
  covariance << 4e-6, 1e-6, -3e-6, 1e-6, 1e-6, 0, -3e-6, 0, 9e-6;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Twin& changed : one_error_away(ball_at(fitted), places, covariance)) {
    const Eigen::Vector3d change = center_of(changed) - fitted;
    sum += change * change.transpose();
  }
  EXPECT_LT((sum - covariance).cwiseAbs().maxCoeff(), 1e-6 * covariance.norm());  // 270 mm + 1e-3: rounding
}

TEST(OneErrorAway, TakesTheOtherSideWhereNoLensIsAndNothingOfNoCovariance) {
  Parameter bounded;
  bounded.change = [](Twin& twin, double change) {
    if (change > 0.0) throw UserError(ExitCode::usage, "k1", "no lens", "");
    twin.objects.push_back({});
  };
  Eigen::MatrixXd variance = Eigen::MatrixXd::Constant(1, 1, 1e-4);
  EXPECT_EQ(one_error_away({}, {bounded}, variance).size(), 1u);
  bounded.change = [](Twin&, double) { throw UserError(ExitCode::usage, "k1", "no lens", ""); };
  EXPECT_TRUE(one_error_away({}, {bounded}, variance).empty());
  variance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(one_error_away({}, {bounded}, variance).empty());
  EXPECT_TRUE(one_error_away({}, {}, {}).empty());
}

ExplainedRow row(const char* quantity, const char* region, double chi2, const char* state) {
  ExplainedRow row;
  row.quantity = quantity, row.region = region, row.state = state;
  row.chi2 = chi2, row.chi2_limit = 13.0;
  return row;
}

TEST(RefinedBudget, ExcusesWhatIsExplainedWithItAndLeavesTheRestAsItWas) {
  std::vector<ExplainedRow> rows = {
      row("geometry", "wall", 16.0, kNotExplained), row("geometry", "ball", 400.0, kNotExplained),
      row("geometry", "gem", 1.0, kExplained), row("phase", "wall", 2.0, kNotExplained)};
  excuse(rows, {row("geometry", "wall", 3.0, kExplained), row("geometry", "ball", 50.0, kNotExplained),
                row("geometry", "gem", 0.5, kExplained)});
  EXPECT_EQ(rows[0].chi2, 3.0);
  EXPECT_EQ(rows[0].state, kExplained);
  EXPECT_EQ(rows[1].chi2, 400.0);  // what got worse is told without the budget
  EXPECT_EQ(rows[2].chi2, 1.0);
  EXPECT_EQ(rows[3].state, kNotExplained);
}

TEST(RefinedBudget, NothingIsRenderedWithoutPlacesOrRenderer) {
  const std::vector<ExplainedRow> rows = {row("geometry", "wall", 16.0, kNotExplained)};
  CompareOptions options;
  EXPECT_FALSE(refined_budget({}, {}, options, rows));
  options.one_error_away = {Twin{}};
  EXPECT_FALSE(refined_budget({}, {}, options, rows));
}

}  // namespace
}  // namespace fringetwin::compare::refined_budget_test
