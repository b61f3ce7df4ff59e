// SPDX-License-Identifier: Apache-2.0
// A measurement in closed form in the place of the chain: y = 5 + 3 z + 2 sqrt(3) w + noise, z and noise of
// sigma 1, w uniform in (-1, 1): variances 9, 4, 1.
// | tolerance | unit  | origin                                                    |
// |-----------|-------|-----------------------------------------------------------|
// | 5         | sigma | of a mean or a sigma of the trials                        |
// | 3         | 1     | half widths of a 95 % interval = 6 sigma of an index      |
#include "study/monte_carlo/monte_carlo_study.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "study/plan/random_draws.hpp"

namespace fringetwin::study::monte_carlo_study_test {
namespace {

MonteCarloPlan plan() {
  MonteCarloPlan out;
  out.inputs.keys.push_back({"z", {"z"}, {5.0}, Distribution::normal, 3.0});
  out.inputs.keys.push_back({"w", {"w"}, {0.0}, Distribution::uniform, 2.0 * std::sqrt(3.0)});
  out.rule = {.coverage = 0.95, .digits = 1, .block_trials = 200, .least_blocks = 5};
  return out;
}

PointOutcome measured(const StudyPoint& point) {
  const double noise = normal_quantile(unit_draw(point.seed, DrawStream::bootstrap, 0, 0));
  PointOutcome out;
  out.id = point.id;
  out.numbers["y"] = std::stod(point.settings.at("z")) + std::stod(point.settings.at("w")) + noise;
  return out;
}

std::vector<PointOutcome> run_all(const std::vector<StudyPoint>& points) {
  std::vector<PointOutcome> out;
  for (const StudyPoint& point : points) out.push_back(measured(point));
  return out;
}

TEST(MonteCarloStudy, StopsByItselfWithTheRightNumbers) {
  const auto result = run_monte_carlo(plan(), run_all);
  ASSERT_TRUE(result.converged);
  const MonteCarloNumber& y = result.numbers.at("y");
  EXPECT_EQ(result.trials % 200, 0u);
  EXPECT_GE(result.trials, 1000u);
  EXPECT_LT(result.trials, 10'000u);
  const double sigma = std::sqrt(14.0), n = static_cast<double>(result.trials);
  EXPECT_EQ(y.summary.n, result.trials);
  EXPECT_NEAR(y.summary.mean, 5.0, 5.0 * sigma / std::sqrt(n));
  EXPECT_NEAR(y.summary.sigma, sigma, 5.0 * sigma / std::sqrt(2.0 * n));
  EXPECT_EQ(y.convergence.tolerance, 0.5);
  EXPECT_LE(y.convergence.high, 0.5);
  EXPECT_TRUE(y.sensitivity.first.empty());
}

TEST(MonteCarloStudy, RanksTheInputs) {
  MonteCarloPlan p = plan();
  p.sensitivity_rows = 2000;
  const auto result = run_monte_carlo(p, run_all);
  EXPECT_GE(result.trials, 2000u) << "the rows are trials";
  ASSERT_EQ(result.factors, (std::vector<std::string>{"z", "w", "noise"}));
  const SobolIndices& s = result.numbers.at("y").sensitivity;
  const std::vector<double> truth = {9.0 / 14.0, 4.0 / 14.0, 1.0 / 14.0};
  for (std::size_t f = 0; f < 3; ++f)
    for (const SobolIndex& index : {s.first[f], s.total[f]})
      EXPECT_NEAR(index.value, truth[f], 3.0 * 0.5 * (index.interval.high - index.interval.low)) << f;
  const auto json = nlohmann::json::parse(monte_carlo_json(p, result));
  EXPECT_EQ(json["numbers"][0]["sensitivity"][0]["factor"], "z");
  EXPECT_EQ(json["numbers"][0]["sensitivity"][2]["factor"], "noise");
  EXPECT_EQ(json["numbers"][0]["sigma"], result.numbers.at("y").summary.sigma);
}

TEST(MonteCarloStudy, PointsAreThoseOfThePlanWhateverRanBefore) {
  MonteCarloPlan p = plan();
  p.sensitivity_rows = 20;
  std::map<std::int64_t, Settings> seen;
  const auto first = run_monte_carlo(p, [&](const std::vector<StudyPoint>& points) {
    for (const StudyPoint& point : points)
      EXPECT_TRUE(seen.emplace(point.id, point.settings).second) << point.id;
    return run_all(points);
  });
  EXPECT_EQ(seen.size(), first.trials + 20 * 4);
  std::size_t asked = 0;
  const auto again = run_monte_carlo(p, [&](const std::vector<StudyPoint>& points) {
    for (const StudyPoint& point : points) {
      EXPECT_EQ(seen.at(point.id), point.settings);
      ++asked;
    }
    return run_all(points);
  });
  EXPECT_EQ(asked, seen.size());
  EXPECT_EQ(monte_carlo_json(p, again), monte_carlo_json(p, first));
}

// A study that has ended without convergence is given more trials: none of its points is another one then.
TEST(MonteCarloStudy, MoreTrialsKeepThePointsThatThereAre) {
  MonteCarloPlan p = plan();
  p.sensitivity_rows = 20;
  p.most_trials = 300;
  std::map<std::int64_t, std::pair<Settings, std::uint64_t>> seen;
  const auto keep = [&](const std::vector<StudyPoint>& points) {
    for (const StudyPoint& point : points) {
      const std::pair now(point.settings, static_cast<std::uint64_t>(point.seed));
      EXPECT_EQ(seen.try_emplace(point.id, now).first->second, now) << point.id;
    }
    return run_all(points);
  };
  ASSERT_FALSE(run_monte_carlo(p, keep).converged);
  const std::size_t before = seen.size();
  EXPECT_EQ(before, 300U + 20U * 4U);
  p.most_trials = 10'000;
  const auto raised = run_monte_carlo(p, keep);
  EXPECT_TRUE(raised.converged);
  EXPECT_EQ(seen.size(), before + raised.trials - 300U);
}

TEST(MonteCarloStudy, FailedAndMissingPointsAreCounted) {
  MonteCarloPlan p = plan();
  p.most_trials = 2000;
  const auto result = run_monte_carlo(p, [](const std::vector<StudyPoint>& points) {
    std::vector<PointOutcome> out = run_all(points);
    for (PointOutcome& o : out) {
      o.failed = o.id % 10 == 3;
      if (o.id % 10 == 4) o.numbers["y"] = std::nan("");
    }
    std::erase_if(out, [](const PointOutcome& o) { return o.id % 10 == 5; });
    return out;
  });
  EXPECT_EQ(result.failed, result.trials / 5);
  EXPECT_EQ(result.numbers.at("y").summary.n, result.trials * 7 / 10);
  EXPECT_NEAR(result.numbers.at("y").summary.sigma, std::sqrt(14.0), 0.5);
}

// Half of the trials stand for a study that was stopped: what is said of them is what they say.
TEST(MonteCarloStudy, TellsWhatAStoppedOneHasSoFar) {
  const MonteCarloPlan p = plan();
  std::vector<StoredPoint> rows;
  const auto store = [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      StoredPoint row;
      row.point = point_of(p.inputs, static_cast<std::int64_t>(i),
                           draw_inputs(p.inputs, p.seed, DrawStream::trials, i));
      row.outcome = measured(row.point);
      row.status = PointStatus::done;
      rows.push_back(row);
    }
  };
  store(0, 850);
  rows[3].status = PointStatus::failed;
  rows[3].outcome.failed = true;
  store(852, 853);  // the one after two that were running
  const MonteCarloResult so_far = monte_carlo_so_far(p, rows);
  EXPECT_EQ(so_far.trials, 851u);
  EXPECT_EQ(so_far.failed, 1u);
  EXPECT_FALSE(so_far.converged);
  const MonteCarloNumber& y = so_far.numbers.at("y");
  EXPECT_EQ(y.summary.n, 850u);
  EXPECT_EQ(y.convergence.blocks, 4u);
  EXPECT_NEAR(y.summary.mean, 5.0, 5.0 * std::sqrt(14.0 / 850.0));
  EXPECT_NEAR(y.summary.sigma, std::sqrt(14.0), 5.0 * std::sqrt(14.0 / 1700.0));
  EXPECT_TRUE(monte_carlo_so_far(p, {}).numbers.empty());
  rows.resize(1);
  EXPECT_FALSE(trials_foreseen(monte_carlo_so_far(p, rows)).has_value());
}

// What is foreseen after each block against what it took: the scatter of few blocks is known to a third.
TEST(MonteCarloStudy, ForeseesHowManyTrialsItTakes) {
  MonteCarloPlan p = plan();
  p.rule.block_trials = 20;
  std::vector<std::optional<std::size_t>> foreseen;
  const auto result = run_monte_carlo(
      p, run_all, [&](const MonteCarloResult& so_far) { foreseen.push_back(trials_foreseen(so_far)); });
  ASSERT_TRUE(result.converged);
  ASSERT_EQ(foreseen.size(), result.trials / 20);
  EXPECT_FALSE(foreseen[1].has_value()) << "of two blocks nothing can be told";
  EXPECT_EQ(foreseen.back(), result.trials);
  ASSERT_GT(foreseen.size(), 20u);
  for (std::size_t k = 9; k < foreseen.size(); ++k) {
    EXPECT_GT(*foreseen[k], result.trials / 3) << k;
    EXPECT_LT(*foreseen[k], 3 * result.trials) << k;
  }
}

TEST(MonteCarloStudy, EndsWithoutConvergenceAtItsLimit) {
  MonteCarloPlan p = plan();
  p.rule.digits = 3;
  p.most_trials = 1100;
  const auto result = run_monte_carlo(p, run_all);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.trials, 1100u) << "the last block is what is left";
  EXPECT_EQ(result.numbers.at("y").summary.n, 1100u);
  const auto none =
      run_monte_carlo(p, [](const std::vector<StudyPoint>&) { return std::vector<PointOutcome>(); });
  EXPECT_FALSE(none.converged);
  EXPECT_EQ(none.failed, 1100u);
  EXPECT_TRUE(none.numbers.empty());
}

}  // namespace
}  // namespace fringetwin::study::monte_carlo_study_test
