// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                                              |
// |-----------|------|---------------------------------------------------------------------|
// | 1e-12     | 1    | rounding of sums of few numbers                                     |
// | 1 %       | 1    | of a chosen value: ten of the search's least steps                  |
// | 5         | sigma| of a standard deviation over many samples, fixed seed               |
#include "study/optimise/optimise.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "study/study_file.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::optimise_test {
namespace {
using namespace fringetwin::study;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kLight = "projector.intensity", kNominalLight = "nominal." + kLight,
                  kRadius = "fits.ball.measured.radius_mm", kFull = "images.left.saturated";

class Optimise : public ::testing::Test {
 protected:
  void SetUp() override {
    write_file(folder_ / "twin.toml", small_twin());
    plan_.twin = folder_ / "twin.toml";
    plan_.choose.push_back({{kLight}, {}, {}, Range{10.0, 90.0, std::nullopt, false}});
    plan_.result = kRadius;
    plan_.constraints.push_back({kFull, std::nullopt, 0.0});
    plan_.evaluations = 40;
    plan_.trials = 4;
    plan_.inputs.keys.push_back({"light", {kLight}, {40.0}, Distribution::normal, 0.5});
  }
  /// The radius spreads as 1/light about 19 + something; from 50 on pixels are full, 4 seconds at 80.
  static PointOutcome measured(const StudyPoint& p) {
    const double light = std::stod(p.settings.at(kNominalLight)),
                 off = std::stod(p.settings.at(kLight)) - light;
    PointOutcome o;
    o.id = p.id;
    o.numbers = {{kRadius, 19.0 + off / light},
                 {kFull, std::max(0.0, light - 50.0) / 100.0},
                 {"acquisition.time_s", light / 20.0}};
    if (light > 80.0) {
      o.failed = true;
      o.reason = "too bright";
    }
    return o;
  }
  static std::vector<PointOutcome> run_all(const std::vector<StudyPoint>& points) {
    std::vector<PointOutcome> out;
    for (const StudyPoint& p : points) out.push_back(measured(p));
    return out;
  }
  StudyFile load(const std::string& text) const {
    write_file(folder_ / "study.toml",
               "schema = \"fringetwin-study/1\"\ntwin = \"twin.toml\"\nkind = \"optimise\"\n" + text);
    return load_study(folder_ / "study.toml");
  }
  std::filesystem::path folder_ = scratch_folder("optimise");
  OptimisePlan plan_;
};

TEST_F(Optimise, FindsTheLimitOfTheConstraint) {
  const OptimiseResult r = run_optimise(plan_, run_all);
  ASSERT_TRUE(r.best);
  const Evaluation& best = r.evaluations[*r.best];
  const double light = std::stod(best.values.at(kLight));
  EXPECT_NEAR(light, 50.0, 0.5);
  EXPECT_LE(light, 50.0);
  EXPECT_TRUE(best.feasible);
  EXPECT_NEAR(best.time_s, light / 20.0, 1e-12);
  EXPECT_LE(r.evaluations.size(), 40u);
  std::size_t failed = 0;
  for (const Evaluation& e : r.evaluations)
    if (std::stod(e.values.at(kLight)) > 80.0) {
      EXPECT_EQ(e.failed, 4u);
      EXPECT_EQ(e.reason, "too bright");
      EXPECT_FALSE(e.feasible);
      ++failed;
    }
  EXPECT_GT(failed, 0u);
  // Less light is quicker and worse: the least light is on the front, and after it what is surely better.
  const auto time_of = [&](std::size_t i) { return r.evaluations[i].time_s; };
  ASSERT_EQ(r.front.size(), 2u);
  for (std::size_t i = 0; i < r.evaluations.size(); ++i)
    EXPECT_TRUE(!r.evaluations[i].feasible || time_of(r.front[0]) <= time_of(i)) << i;
  EXPECT_TRUE(
      is_surely_less(r.last_of(r.front[1]).objective, r.last_of(r.front[0]).objective, Statistic::sigma));
  // The brightest five, 2 % of the range or more apart.
  ASSERT_EQ(r.candidates.size(), 5u);
  EXPECT_EQ(r.candidates[0].evaluation, *r.best);
  for (std::size_t k = 1; k < 5; ++k)
    EXPECT_LT(time_of(r.candidates[k].evaluation),
              time_of(r.candidates[k - 1].evaluation) - 0.019 * 80.0 / 20.0);
  for (const std::size_t i : r.not_told_apart()) EXPECT_LE(time_of(*r.recommended), time_of(i));
  const auto json = nlohmann::json::parse(optimise_json(plan_, r));
  EXPECT_EQ(json["schema"], "fringetwin-optimise/1");
  EXPECT_EQ(json["best"], *r.best);
  EXPECT_EQ(json["evaluations"].size(), r.evaluations.size());
  EXPECT_EQ(json["candidates"][4]["evaluation"], r.candidates[4].evaluation);
  EXPECT_EQ(json["chosen"]["recommended"], *r.recommended);
  EXPECT_EQ(json["chosen"]["objective_interval"][1], r.chosen->objective.interval.high);
  EXPECT_EQ(json["chosen"]["not_told_apart"].size(), r.not_told_apart().size());
}

TEST_F(Optimise, EveryEvaluationHasTheSameDraws) {
  std::vector<StudyPoint> points, again;
  const OptimiseResult r = run_optimise(plan_, [&](const std::vector<StudyPoint>& batch) {
    std::vector<StudyPoint>& of = batch[0].id < 40 * 4 ? points : again;
    of.insert(of.end(), batch.begin(), batch.end());
    return run_all(batch);
  });
  ASSERT_EQ(again.size(), 16 * (r.candidates.size() + 1)) << "each of the best, and the best of them";
  std::set<std::uint64_t> seeds;
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].id, static_cast<std::int64_t>(160 + i));
    if (i < 16 * r.candidates.size()) {
      EXPECT_EQ(again[i].seed, again[i % 16].seed) << "common to the best";
    }
    seeds.insert(again[i].seed);
  }
  for (std::size_t i = 0; i < 4; ++i) seeds.insert(points[i].seed);
  EXPECT_EQ(seeds.size(), 4u + 16u + 16u) << "the three sets have no draw in common";
  ASSERT_GT(points.size(), 12u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].id, static_cast<std::int64_t>(i));
    EXPECT_EQ(points[i].seed, points[i % 4].seed);
    const auto off = [&](const StudyPoint& p) {
      return std::stod(p.settings.at(kLight)) - std::stod(p.settings.at(kNominalLight));
    };
    EXPECT_NEAR(off(points[i]), off(points[i % 4]), 1e-12) << "off from what is chosen";
  }
  EXPECT_NE(points[0].seed, points[1].seed);
  VirtualRig rig(plan_.twin, false);
  const double light = std::stod(points[5].settings.at(kNominalLight));
  EXPECT_EQ(rig.measuring(points[5].settings).projector->intensity, light) << "the rig knows what is chosen";
  EXPECT_NE(rig.drawn(points[5].settings).projector->intensity, light);
}

TEST_F(Optimise, GoesOnFromWhatIsKept) {
  const OptimiseResult whole = run_optimise(plan_, run_all);
  std::map<std::int64_t, PointOutcome> kept;
  std::size_t n = 0;
  const auto run = [&](std::size_t most) {
    return run_optimise(plan_, [&](const std::vector<StudyPoint>& batch) {
      std::vector<PointOutcome> out;
      for (const StudyPoint& p : batch) {
        if (!kept.contains(p.id)) {
          if (++n > most) throw std::runtime_error("killed");
          kept[p.id] = measured(p);
        }
        out.push_back(kept.at(p.id));
      }
      return out;
    });
  };
  for (const std::size_t most : {3, 50, 97}) EXPECT_THROW(run(most), std::runtime_error);
  EXPECT_EQ(optimise_json(plan_, run(100'000)), optimise_json(plan_, whole));
  EXPECT_EQ(kept.size(), 4 * whole.evaluations.size() + 16 * (whole.candidates.size() + 1));
}

TEST_F(Optimise, ListsAndMissingNumbers) {
  plan_.choose = {
      {{"fringes.steps"}, {"3", "4", "8"}, {}, std::nullopt},
      {{"fringes.pitches_px[0]", "fringes.pitches_px[1]"}, {}, {{"13", "14"}, {"26", "28"}}, std::nullopt}};
  plan_.choose[1].values = {"13", "26"};
  plan_.constraints.clear();
  const OptimiseResult r = run_optimise(plan_, [](const std::vector<StudyPoint>& points) {
    std::vector<PointOutcome> out;
    for (const StudyPoint& p : points) {
      const double steps = std::stod(p.settings.at("nominal.fringes.steps")),
                   pitch = std::stod(p.settings.at("nominal.fringes.pitches_px[1]"));
      out.emplace_back();
      out.back().id = p.id;
      out.back().numbers = {{kRadius, 19.0 + pitch / steps * static_cast<double>(p.id % 4)},
                            {"acquisition.time_s", steps}};
      if (steps == 8.0 && pitch == 14.0 && p.id % 4 == 2) out.back().numbers[kRadius] = std::nan("");
    }
    return out;
  });
  ASSERT_EQ(r.evaluations.size(), 6u);
  ASSERT_TRUE(r.best);
  EXPECT_EQ(
      r.evaluations[*r.best].values,
      (Settings{{"fringes.steps", "4"}, {"fringes.pitches_px[0]", "13"}, {"fringes.pitches_px[1]", "14"}}));
  const auto lost = std::find_if(r.evaluations.begin(), r.evaluations.end(),
                                 [](const Evaluation& e) { return e.failed > 0; });
  ASSERT_NE(lost, r.evaluations.end());
  EXPECT_EQ(lost->failed, 1u);
  EXPECT_THAT(lost->reason, HasSubstr("there is no fits.ball"));
  // 4 steps are 4/3 as good as 3: less than sixteen trials tell apart
  EXPECT_EQ(r.front.size(), 1u);
  EXPECT_EQ(r.evaluations[*r.recommended].values.at("fringes.steps"), "3");
}

TEST_F(Optimise, StatisticsAndTheirStandardErrors) {
  const std::vector<double> x = {1.0, 3.0, 2.0, 6.0};  // mean 3, variance 14/3
  EXPECT_NEAR(statistic_of(x, Statistic::mean).value, 3.0, 1e-12);
  EXPECT_NEAR(statistic_of(x, Statistic::mean).sigma, std::sqrt(14.0 / 3.0 / 4.0), 1e-12);
  EXPECT_NEAR(statistic_of(x, Statistic::sigma).value, std::sqrt(14.0 / 3.0), 1e-12);
  EXPECT_NEAR(statistic_of(x, Statistic::rms_error, 2.0).value, std::sqrt(18.0 / 4.0), 1e-12);
  EXPECT_TRUE(std::isnan(statistic_of({1.0}, Statistic::mean).value));
  EXPECT_TRUE(std::isnan(statistic_of({1.0, NAN}, Statistic::sigma).value));
  // Each standard error against the scatter of many estimates of 16 normal values with mean 0.5.
  constexpr int n = 4000, m = 16;
  for (const Statistic s : {Statistic::mean, Statistic::sigma, Statistic::rms_error}) {
    double mean = 0.0, square = 0.0, stated = 0.0;
    for (int i = 0; i < n; ++i) {
      std::vector<double> v;
      for (std::uint32_t k = 0; k < m; ++k)
        v.push_back(0.5 +
                    normal_quantile(unit_draw(3, DrawStream::trials, static_cast<std::uint64_t>(i), k)));
      const study::StatisticValue e = statistic_of(v, s, 0.0);
      mean += e.value / n;
      square += e.value * e.value / n;
      stated += e.sigma / n;
    }
    const double found = std::sqrt(square - mean * mean);
    EXPECT_NEAR(stated / found, 1.0, 5.0 / std::sqrt(2.0 * n) + 1.0 / m) << "first order in 1/m";
  }
}

TEST_F(Optimise, TheFileSaysWhatIsChosenAndWhy) {
  const std::string light = "[[choose]]\nkey = \"projector.intensity\"\nrange = [10, 90]\nscale = \"log\"\n",
                    least = "[minimise]\nresult = \"fits.ball.measured.radius_mm\"\n",
                    full = "[[constraint]]\nresult = \"images.left.saturated\"\nmax = 0.01\n";
  const StudyFile study =
      load("evaluations = 30\ntrials = 5\nseed = 4\n" + light +
           "[[choose]]\nkey = \"fringes.steps\"\nvalues = [3, 4, 8]\n" +
           "[minimise]\nresult = \"fits.ball.measured.radius_mm\"\nstatistic = \"rms-error\"\n"
           "value = 19\n" +
           full);
  ASSERT_TRUE(std::holds_alternative<OptimisePlan>(study.plan));
  const OptimisePlan& plan = std::get<OptimisePlan>(study.plan);
  EXPECT_EQ(plan.choose.size(), 2u);
  EXPECT_TRUE(plan.choose[0].range->log);
  EXPECT_THAT(plan.choose[1].values, ElementsAre("3", "4", "8"));
  EXPECT_EQ(plan.statistic, Statistic::rms_error);
  EXPECT_EQ(plan.value, 19.0);
  EXPECT_EQ(plan.constraints[0].max, 0.01);
  EXPECT_EQ(plan.evaluations, 30u);
  EXPECT_EQ(plan.trials, 5u);
  ASSERT_EQ(study.head.records.size(), 3u);
  EXPECT_EQ(study.head.records[0].name, "acquisition.time_s");

  const auto refused = [&](const std::string& text, const std::string& sentence) {
    SCOPED_TRACE(text);
    expect_user_error(ExitCode::usage, sentence, [&] { load(text); });
  };
  refused(least, "[[choose]]");
  refused(light, "[minimise]");
  refused(light + light + least, "a second time");
  refused("[[choose]]\nkey = \"camera[0].psf_px\"\nrange = [0, 1]\n" + least, "goes by number");
  refused(light + "[minimise]\nresult = \"x\"\nstatistic = \"rms-error\"\n", "value");
  refused(light + "[minimise]\nresult = \"x\"\nvalue = 3\n", "no effect");
  refused(light + least + "[[constraint]]\nresult = \"x\"\n", "min, max or both");
  refused(light + least + "[[constraint]]\nresult = \"x\"\nmin = 2\nmax = 1\n", "below min");
  refused("evaluations = 100000\ntrials = 100\n" + light + least, "must not exceed");
  refused("noise = false\n" + light + least, "nothing is uncertain");
  refused(light + least + "[[uncertain]]\nkey = \"projector.intensity\"\nsigma = 1\nvalue = 40\n",
          "is chosen, too");
  refused(light + least + "[[record]]\nresult = \"x\"\n", "record");
}

}  // namespace
}  // namespace fringetwin::testing::optimise_test
