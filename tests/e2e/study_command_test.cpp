// SPDX-License-Identifier: Apache-2.0
// `study` as a user runs it: the numbers of `render` and `measure`, failures noted, nothing lost by a kill.
// tolerance: none, tables are compared byte by byte and numbers as they are printed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/program/study_folder.hpp"
#include "tests/support/twin/child_process.hpp"

namespace fringetwin::testing::study_command_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string design(int seeds) {
  return kSmallStudy + fmt::format("noise_seeds = {}\n", seeds) + kRadiiAndSensors + R"([[record]]
result = "fits.ball.measured.radius_mm"
name = "radius_mm"
[[record]]
result = "fits.ball.measured.center_mm[2]"
)";
}

/// Cells without quotes in them.
std::vector<std::vector<std::string>> csv(const fs::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(read_file(file));
  for (std::string line; std::getline(lines, line);) {
    auto& row = rows.emplace_back();
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

TEST(StudyCommand, TheNumbersOfRenderAndMeasure) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_numbers", kSmallStudy + R"(first_noise_seed = 5
[[vary]]
key = "object.ball.radius_mm"
values = [18.5]
[[record]]
result = "fits.ball.measured.radius_mm"
)");
  ASSERT_EQ(run_study(dir).exit_code, 0);
  const auto table = csv(dir / "out/study.csv");
  ASSERT_EQ(table.size(), 2U);

  write_file(dir / "alone.toml", small_twin({{"radius_mm = 19", "radius_mm = 18.5"}}));
  const std::string alone = (dir / "alone.toml").string(), images = (dir / "images").string();
  ASSERT_EQ(run_fringetwin({"render", alone, "--out", images, "--seed", "5"}).exit_code, 0);
  ASSERT_EQ(run_fringetwin({"measure", alone, "--captures", images, "--out", images}).exit_code, 0);
  const double radius_mm = read_json(dir / "images/result.json")["fits"][0]["measured"]["radius_mm"];
  EXPECT_EQ(std::stod(table[1].back()), radius_mm);
}

TEST(StudyCommand, AFailingPointIsNotedAndTheRestGoesOn) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_failing", design(3));
  const RunResult run = run_study(dir, "out", {"--jobs", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("18 measured, 6 failed, 24 of them in this run"));
  EXPECT_THAT(run.out, HasSubstr("light traced for 3 of 24 points: 21 traces saved"));
  EXPECT_THAT(run.err, HasSubstr("it is inside the sphere \"ball\""));
  const std::string table = read_file(dir / "out/study.csv");
  EXPECT_EQ(csv(dir / "out/study.csv").size(), 25U);
  EXPECT_TRUE(fs::exists(dir / "out/study.db"));
  EXPECT_THAT(read_file(dir / "out/report.html"), HasSubstr("6 of 24 runs failed"));

  // again: nothing is left to do, and a failed point has had its turn
  const RunResult again = run_study(dir);
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.out, HasSubstr("18 measured, 6 failed, 0 of them in this run"));
  EXPECT_EQ(read_file(dir / "out/study.csv"), table);
  // side by side: the same table
  EXPECT_EQ(run_study(dir, "two", {"--jobs", "3"}).exit_code, 0);
  EXPECT_EQ(read_file(dir / "two/study.csv"), table);
}

/// Ends the study by a signal after a time; true when it came to its end before.
bool run_until(const fs::path& dir, const char* signal, double seconds) {
  const std::string command =
      fmt::format("timeout -s {} {:.3f} '{}' -q study '{}' --out '{}' 2>&1", signal, seconds,
                  std::getenv("FRINGETWIN_BINARY"), (dir / "STUDY.toml").string(), (dir / "killed").string());
  return testing::run(command).status == 0;
}

int stored(const fs::path& dir, const std::string& out = "killed") {
  const auto count = testing::run(fmt::format(
      "python3 -c \"import sqlite3; print(sqlite3.connect('{}').execute(\\\"select count(*) from points "
      "where status <> 'pending'\\\").fetchone()[0])\" 2>/dev/null || echo 0",
      (dir / out / "study.db").string()));
  return std::atoi(count.output.c_str());
}

TEST(StudyCommand, KilledAtRandomTheTableIsThatOfAnUnbrokenRun) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_kills", design(30));
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run_study(dir, "unbroken").exit_code, 0);
  const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> moment(0.15, 0.8);
  constexpr int wanted = 10, wanted_halfway = 4;
  // What else runs on the machine changes how long a study takes: the moments follow.
  double scale_s = whole_s;
  int kills = 0, halfway = 0, rounds = 0;
  bool ended = false;
  const auto enough = [&] { return kills >= wanted && halfway >= wanted_halfway; };
  for (int attempt = 0; attempt < 100 && !(enough() && ended); ++attempt) {
    ended = run_until(dir, "KILL", enough() ? 300.0 : moment(random) * scale_s);  // at last undisturbed
    if (!ended) {
      ++kills;
      const int n = fs::exists(dir / "killed/study.db") ? stored(dir) : 0;
      halfway += n > 0 && n < 240 ? 1 : 0;
      if (n == 0) scale_s *= 1.3;
      // the table comes last but for the page
      if (fs::exists(dir / "killed/study.csv")) {
        EXPECT_EQ(read_file(dir / "killed/study.csv"), read_file(dir / "unbroken/study.csv"))
            << "a broken-off study looks complete";
      }
      continue;
    }
    ++rounds;
    scale_s *= 0.8;
    ASSERT_EQ(read_file(dir / "killed/study.csv"), read_file(dir / "unbroken/study.csv"));
    fs::remove_all(dir / "killed");
  }
  EXPECT_GE(kills, wanted);
  EXPECT_GT(rounds, 0);
  EXPECT_GE(halfway, wanted_halfway) << "the kills came before there was anything to lose";
  std::printf("killed %d times, %d of them between points; %d tables completed\n", kills, halfway, rounds);
}

TEST(StudyCommand, CtrlCStopsAndTheSameCommandGoesOn) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_interrupted", kSmallStudy + R"(noise_seeds = 1500
[[vary]]
key = "camera.left.sensor.electrons_per_dn"
values = [40.0]
)");
  // However long the first points take on a busy machine. In the foreground: else `timeout` signals the
  // program and then its group, and the second signal, where it comes late enough, ends the program at once.
  std::string output;
  for (double seconds = 1.5; seconds < 100.0 && stored(dir) == 0; seconds *= 2.0)
    output = testing::run(
                 fmt::format("timeout --foreground -s INT {} '{}' study '{}' --out '{}' 2>&1; echo code $?",
                             seconds, std::getenv("FRINGETWIN_BINARY"), (dir / "STUDY.toml").string(),
                             (dir / "killed").string()))
                 .output;
  EXPECT_THAT(output, HasSubstr("of 1500 points finished; the same command goes on from there"));
  EXPECT_THAT(output, HasSubstr("cancelled by the user"));
  EXPECT_FALSE(fs::exists(dir / "killed/report.html"));
  const int before = stored(dir);
  EXPECT_GT(before, 0);
  EXPECT_LT(before, 1500);
  const RunResult rest = run_study(dir, "killed");
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.err, HasSubstr(fmt::format("; {} done before", before)));
  EXPECT_THAT(rest.out,
              HasSubstr(fmt::format("1500 measured, 0 failed, {} of them in this run", 1500 - before)));
}

TEST(StudyCommand, ARefusedFolderKeepsWhatItHas) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_refused", design(1));
  ASSERT_EQ(run_study(dir).exit_code, 0);
  const std::string table = read_file(dir / "out/study.csv"), page = read_file(dir / "out/report.html");
  const auto kept = [&] {
    return fs::exists(dir / "out/study.csv") && read_file(dir / "out/study.csv") == table &&
           fs::exists(dir / "out/report.html") && read_file(dir / "out/report.html") == page;
  };
  write_file(dir / "STUDY.toml", design(2));
  expect_refused(run_study(dir), 2, {"study.db", "holds another study"});
  EXPECT_TRUE(kept());
  write_file(dir / "STUDY.toml", design(1));
  std::string damaged = read_file(dir / "out/study.db");
  for (std::size_t i = 100; i < damaged.size(); ++i) damaged[i] = 'x';
  write_file(dir / "out/study.db", damaged);
  const RunResult run = run_study(dir);
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr("study.db"));
  EXPECT_TRUE(kept());
}

TEST(StudyCommand, AResultThatNoPointHasEndsItAtTheFirst) {
  FT_NEED_DEVICE();
  const fs::path dir =
      study_folder("study_result",
                   kSmallStudy + "noise_seeds = 50\n[[record]]\nresult = \"fits.ball.measured.radus_mm\"\n");
  expect_refused(run_study(dir), 2, {"radus_mm", "radius_mm"});
  EXPECT_EQ(stored(dir, "out"), 0);
}

TEST(StudyCommand, WhatCannotWorkIsSaidBeforeAnyPoint) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_refused", design(3));
  expect_refused(run_study(dir, "out", {"--device", "no such device"}), 4, {"no such device"});
  const RunResult run = run_study(dir);
  EXPECT_THAT(run.out, HasSubstr("24 of them in this run")) << "no point was marked as failed for that";

  write_file(dir / "STUDY.toml", kSmallStudy + "[[vary]]\nkey = \"object.ball.radius_mm\"\nvalues = [900]\n");
  expect_refused(run_study(dir, "none"), 2, {"no point could be measured", "inside the sphere"});
  write_file(dir / "STUDY.toml", kSmallStudy + "[[vary]]\nkey = \"object.ball.radius\"\nvalues = [19]\n");
  expect_refused(run_study(dir, "key"), 2, {"object.ball.radius", "radius_mm"});
  write_file(dir / "STUDY.toml", kSmallStudy +
                                     "[[vary]]\nkey = \"object.ball.radius_mm\"\nvalues = [19]\n"
                                     "[[record]]\nresult = \"fits.ball.measured.radius\"\n");
  expect_refused(run_study(dir, "record"), 2, {"there is no \"radius\"", "radius_mm"});
}

TEST(StudyCommand, PointsThatTheTheoryDoesNotKnowKeepTheirMeasuredNumbers) {
  FT_NEED_DEVICE();
  const std::string record = R"([[record]]
result = "fits.ball.measured.radius_mm"
name = "radius_mm"
expected_sigma = "theory.ball.radius_sigma_mm"
)",
                    vary = "noise_seeds = 2\n[[vary]]\nkey = \"camera.left.psf_px\"\nvalues = ";
  const fs::path dir = study_folder("study_theory", kSmallStudy + vary + "[0, 0.3]\n" + record);
  const RunResult run = run_study(dir);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("4 measured, 0 failed"));
  EXPECT_THAT(run.err, HasSubstr("no number for 2 of 4 points"));
  EXPECT_THAT(run.err, HasSubstr("camera.left.psf_px = 0.3 (2 points)"));
  const nlohmann::json points = nlohmann::json::parse(run_study(dir, "out", {"--json"}).out)["points"];
  ASSERT_EQ(points.size(), 4U);
  for (const auto& point : points) {
    EXPECT_FALSE(point["results"]["radius_mm"].is_null());
    EXPECT_EQ(point["results"]["radius_mm.expected_sigma"].is_null(), point["id"] >= 2);
  }
  write_file(dir / "STUDY.toml", kSmallStudy + vary + "[0.3, 1]\n" + record);
  expect_refused(run_study(dir, "none"), 2, {"radius_mm.expected_sigma", "camera.left.psf_px = 0.3"});
  EXPECT_FALSE(fs::exists(dir / "none")) << "before anything is traced";
}

TEST(StudyCommand, AColumnThatIsNullInAllRunsIsTold) {
  FT_NEED_DEVICE();
  const fs::path dir = study_folder("study_null", kSmallStudy + R"(noise_seeds = 2
[[record]]
result = "fits.ball.method_bias.radius_mm"
name = "bias_mm"
)");
  const RunResult run = run_study(dir);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("\"bias_mm\" is null in all 2 runs"));
  EXPECT_THAT(run.err, HasSubstr("measure --method-bias"));
  EXPECT_THAT(read_file(dir / "out/report.html"), ::testing::Not(HasSubstr("The seeds made no difference")));
}

}  // namespace
}  // namespace fringetwin::testing::study_command_test
