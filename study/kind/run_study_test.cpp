// SPDX-License-Identifier: Apache-2.0
// The walk through a study, with a kind and an engine made for the test: what is written, said and kept does
// not depend on what the kind is.
#include "study/kind/run_study.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::run_study_test {
namespace {
using namespace fringetwin::study;
using ::testing::HasSubstr;

/// Gives each point its id as a number; fails all, or stops as by Ctrl-C after so many.
class QuickEngine final : public Engine {
 public:
  bool fails = false;
  std::int64_t first_outside_gate = 1000;  ///< id of the first point that has a gate warning
  std::size_t most = 1000;
  EngineSummary run(const PointTask&, const std::vector<PlannedPoint>& plan,
                    const std::set<std::int64_t>& done,
                    const std::function<void(const PointOutcome&)>& finished) override {
    EngineSummary summary;
    for (const PlannedPoint& p : plan) {
      if (done.contains(p.point.id)) continue;
      if (summary.finished == most) throw Cancelled();
      PointOutcome outcome{p.point.id, fails, fails ? "it is dark" : "", {}, 0.5, true};
      if (!fails) outcome.numbers["id"] = static_cast<double>(p.point.id);
      if (p.point.id >= first_outside_gate)
        outcome.gate_warnings = {"ball: the gate cuts point " + std::to_string(p.point.id)};
      finished(outcome);
      summary.count(outcome);
    }
    return summary;
  }
};

/// Adds up the ids of four points.
class SumKind final : public Kind {
 public:
  SumKind(const StudyHead& head, bool has_result) : head_(head), has_result_(has_result) {
    for (std::int64_t id = 0; id < 4; ++id) points_.push_back({id, {}, 1});
  }
  bool has_result() const override { return has_result_; }
  PointSequence plan() override { return points_; }
  PointTask task() const override { return {head_.twin, {}}; }
  void run(KeptPoints& points) override {
    for (const PointOutcome& o : points.run(points_)) sum_ += o.failed ? 0.0 : o.number("id");
  }
  std::string write() const override { return std::to_string(sum_); }
  StudyReport report(const StudyRecord& study) const override {
    return {std::to_string(study.rows.size()) + " rows", {{"drawing", "<svg/>"}}};
  }
  std::string tell(const StudyRecord&, const EngineSummary& summary) const override {
    return points_text(summary.finished) + "\n";
  }
  std::string tell_stopped(const std::vector<StoredPoint>& rows) const override {
    return points_text(rows.size()) + " so far\n";
  }
  bool has_page_so_far() const override { return true; }
  std::optional<StudyReport> report_so_far(const StudyRecord& study) const override {
    return StudyReport{std::to_string(study.rows.size()) + " rows so far", {}};
  }
  ExitCode verdict() const override { return ExitCode::no_convergence; }

 private:
  const StudyHead& head_;
  bool has_result_;
  std::vector<StudyPoint> points_;
  double sum_ = 0.0;
};

class RunStudyTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_file(folder_ / "twin.toml", small_twin());
    head_.file = folder_ / "study.toml";
    head_.twin = folder_ / "twin.toml";
  }
  /// Runs it with a Kind of its own, as a command does; what is said on stdout is in said_.
  ExitCode run(bool figures = false, bool json = false) {
    SumKind kind(head_, has_result_);
    said_.clear();
    const auto print = [&](const std::string& text) { said_ += text; };
    return run_study(kind, head_, {folder_ / "out", engine_, argv_, "1", figures, print, json});
  }
  ExitCode show_so_far(bool json = false) {
    SumKind kind(head_, has_result_);
    said_.clear();
    const auto print = [&](const std::string& text) { said_ += text; };
    return show_study_so_far(kind, head_, {folder_ / "out", engine_, {}, "1", false, print, json});
  }
  std::filesystem::path folder_ = scratch_folder("run_study");
  StudyHead head_;
  QuickEngine engine_;
  bool has_result_ = true;
  std::vector<std::string> argv_ = {"fringetwin", "study", "a ball.toml", "--figures", "--out", "out"};
  std::string said_;
};

TEST_F(RunStudyTest, WritesTableResultPageAndDrawings) {
  EXPECT_EQ(run(true), ExitCode::no_convergence);
  EXPECT_EQ(said_, "4 points\nlight traced for 4 of 4 points: 0 traces saved\n");
  EXPECT_THAT(read_file(folder_ / "out/study.csv"), HasSubstr("\r\n3,1,done,,3\r\n"));
  EXPECT_THAT(read_file(folder_ / "out/result.json"), HasSubstr("6.0"));
  EXPECT_EQ(read_file(folder_ / "out/report.html"), "4 rows");
  EXPECT_EQ(read_file(folder_ / "out/figures/drawing.svg"), "<svg/>");
  EXPECT_EQ(run(), ExitCode::no_convergence);
  EXPECT_EQ(said_, "0 points\nlight traced for 0 of 0 points: 0 traces saved\n") << "nothing is run twice";
  EXPECT_THAT(read_file(folder_ / "out/result.json"), HasSubstr("6.0")) << "from what is kept";
}

TEST_F(RunStudyTest, GoesOnWhereItStopped) {
  run();
  std::filesystem::remove(folder_ / "out/study.db");
  engine_.most = 3;
  ::testing::internal::CaptureStderr();
  EXPECT_THROW(run(), Cancelled);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              HasSubstr("`fringetwin study 'a ball.toml' --out out --so-far` makes a page of that\n"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.html")) << "of a study that is not complete";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/study.csv"));
  EXPECT_EQ(said_, "3 points so far\n");
  EXPECT_THAT(read_file(folder_ / "out/unfinished.csv"), HasSubstr("\r\n2,1,done,,2\r\n"));
  EXPECT_THAT(read_file(folder_ / "out/unfinished.csv"), ::testing::Not(HasSubstr("\r\n3,")));
  engine_.most = 1;
  run();
  EXPECT_THAT(said_, HasSubstr("1 point\n"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/unfinished.csv"));
}

TEST_F(RunStudyTest, ShowsAStoppedOneWithoutRunningAnything) {
  EXPECT_THROW(show_so_far(), UserError) << "no study there";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  engine_.most = 3;
  EXPECT_THROW(run(), Cancelled);
  std::filesystem::remove(folder_ / "out/unfinished.csv");
  engine_.most = 0;  // would stop at once
  EXPECT_EQ(show_so_far(), ExitCode::ok);
  EXPECT_EQ(said_, "3 points so far\n");
  EXPECT_THAT(read_file(folder_ / "out/unfinished.csv"), HasSubstr("\r\n2,1,done,,2\r\n"));
  EXPECT_EQ(read_file(folder_ / "out/unfinished.html"), "3 rows so far");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.html"));
  show_so_far(true);
  EXPECT_EQ(nlohmann::json::parse(said_)["points"].size(), 3U);
  engine_.most = 1000;
  run();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/unfinished.html")) << "of a study that is finished";
  EXPECT_THAT(read_file(folder_ / "out/study.csv"), HasSubstr("\r\n3,1,done,,3\r\n"));
}

TEST_F(RunStudyTest, JsonIsAllThatIsOnStdout) {
  ::testing::internal::CaptureStderr();
  run(false, true);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("4 points\n")) << "words go there";
  EXPECT_EQ(said_, read_file(folder_ / "out/result.json"));
  engine_.most = 1;
  std::filesystem::remove(folder_ / "out/study.db");
  EXPECT_THROW(run(false, true), Cancelled);
  EXPECT_EQ(said_, "") << "half a result is none";
}

TEST_F(RunStudyTest, JsonOfAKindWithoutAResultIsItsTable) {
  has_result_ = false;
  run(false, true);
  const auto table = nlohmann::json::parse(said_);
  EXPECT_EQ(table["schema"], "fringetwin-study-table/1");
  ASSERT_EQ(table["points"].size(), 4U);
  EXPECT_EQ(table["points"][3],
            nlohmann::json::parse(R"({"id": 3, "settings": {}, "noise_seed": 1, "status": "done",
                                                          "reason": "", "results": {"id": 3.0}})"));
}

// Of a thousand points whose gates are too small nobody wants to read a thousand sentences.
TEST_F(RunStudyTest, TellsTheGateWarningsOfTheFirstPointAndHowManyMore) {
  const auto stderr_of_a_run = [&] {
    ::testing::internal::CaptureStderr();
    run();
    return ::testing::internal::GetCapturedStderr();
  };
  engine_.first_outside_gate = 1;
  const std::string three = stderr_of_a_run();
  EXPECT_THAT(three, HasSubstr("warning: point 1: ball: the gate cuts point 1\n"));
  EXPECT_THAT(three, ::testing::Not(HasSubstr("the gate cuts point 2")));
  EXPECT_THAT(three, HasSubstr("warning: 2 more of the points of this run have such warnings"));
  std::filesystem::remove(folder_ / "out/study.db");
  engine_.first_outside_gate = 3;
  const std::string one = stderr_of_a_run();
  EXPECT_THAT(one, HasSubstr("point 3: ball"));
  EXPECT_THAT(one, ::testing::Not(HasSubstr("of this run")));
}

TEST_F(RunStudyTest, WithoutAMeasuredPointItIsNoSuccess) {
  engine_.fails = true;
  try {
    run();
    ADD_FAILURE() << "no point was measured";
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    EXPECT_THAT(e.what(), HasSubstr("study.toml: no point could be measured: it is dark"));
  }
}

}  // namespace
}  // namespace fringetwin::testing::run_study_test
