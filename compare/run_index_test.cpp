// SPDX-License-Identifier: Apache-2.0
// The index of many runs: what their files say is on it, and what they could do to it is not.
// tolerance: none, texts are exact; the held-out ratio is rounded to 0.001.
#include "compare/run_index.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "report/html_page.hpp"

namespace fringetwin::compare::run_index_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class RunIndex : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(dir_); }
  void TearDown() override { fs::remove_all(dir_); }
  void write(const fs::path& file, const std::string& text) {
    fs::create_directories((dir_ / file).parent_path());
    std::ofstream(dir_ / file) << text;
  }
  /// Writes a page as a comparison does.
  void write_page(const fs::path& folder, const std::string& answer) {
    report::Page page;
    page.title = "a rig";
    page.answer = answer;
    page.verdict = "explained; no limits set";
    write(folder / "report.html", page.html());
  }
  /// Writes a page as the other commands do, without an answer.
  void write_titled_page(const fs::path& file, const std::string& title, const std::string& verdict = "") {
    report::Page page;
    page.title = title;
    page.verdict = verdict;
    write(file, page.html());
  }
  std::string index() {
    return run_index_html(dir_, runs_below(dir_), {"fringetwin", "index", "a b"}, "1.2.3");
  }
  fs::path dir_ = fs::temp_directory_path() / ("fringetwin_run_index_" + std::to_string(::getpid()));
};

constexpr const char* kResult = R"({"schema": "fringetwin-result/1", "twin": "two <b> spheres",
  "provenance": {"argv": ["fringetwin", "cosim", "twin.toml"]},
  "gain": [{"camera": "left", "gain_dn": 17.30291, "gain_sigma_dn": 0.00412},
           {"camera": "right", "gain_dn": 1234.5, "gain_sigma_dn": null}],
  "phase": [{"camera": "left", "rms_rad": 0.01}, {"camera": "right", "rms_rad": 0.02}, {"rms_rad": null}],
  "held_out": [{"camera": "left", "n": 1, "rms_dn": 3, "predicted_dn": 1},
               {"camera": "left", "n": 3, "rms_dn": 1, "predicted_dn": 1},
               {"camera": "right", "n": 9, "rms_dn": 1, "predicted_dn": 1}, {"camera": "right", "n": "9"}]})";

TEST_F(RunIndex, ARowSaysWhatTheRunFound) {
  write("b/result.json", kResult);
  write_page("b", "Twin & rig agree.");
  write("a/deep/result.json", kResult);
  const std::vector<RunSummary> runs = runs_below(dir_);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].folder, "a/deep") << "by their paths";
  EXPECT_EQ(runs[0].page, "");
  EXPECT_EQ(runs[1].twin, "two <b> spheres");
  EXPECT_EQ(runs[1].command, "cosim");
  EXPECT_EQ(runs[1].answer, "Twin & rig agree.");
  EXPECT_EQ(runs[1].verdict, "explained; no limits set");
  EXPECT_DOUBLE_EQ(runs[1].held_out_ratio, std::sqrt(12.0 / 4.0)) << "the rms of the worst camera";
  EXPECT_EQ(runs[1].phase_rms_rad, 0.02);
  const std::string html = index();
  EXPECT_THAT(html, HasSubstr("<a href=\"b/report.html\">b</a>"));
  EXPECT_THAT(html, HasSubstr("two &lt;b&gt; spheres"));
  EXPECT_THAT(html, HasSubstr("Twin &amp; rig agree."));
  EXPECT_THAT(html, HasSubstr("17.3029 ± 0.0041, 1234"));
  EXPECT_THAT(html, HasSubstr(">1.732<"));
  EXPECT_THAT(html, HasSubstr(">0.02000<"));
  EXPECT_THAT(html, HasSubstr("no page: the run has not ended"));
  EXPECT_THAT(html, HasSubstr("fringetwin index &#39;a b&#39;"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
}

TEST_F(RunIndex, PagesOfStudiesAndMeasurementsHaveRowsToo) {
  write("study/study.db", "");
  write("study/result.json", R"({"kind": "monte-carlo"})");
  write_page("study", "The radius is 5.");
  write_page("page", "12 points.");
  write("others/report.html", "<html><header><h1>mine</h1></header></html>");
  const std::vector<RunSummary> runs = runs_below(dir_);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].answer, "12 points.");
  EXPECT_EQ(runs[1].command, "study");
  EXPECT_EQ(runs[1].answer, "The radius is 5.");
  EXPECT_EQ(runs[1].fault, "") << "a study's result.json is of another kind";
}

TEST_F(RunIndex, AStudyThatIsNotFinishedSaysSo) {
  write("running/study.db", "");
  write("stopped/study.db", "");
  write_titled_page("stopped/unfinished.html", "Study “ball”", "not converged");
  const std::vector<RunSummary> runs = runs_below(dir_);
  ASSERT_EQ(runs.size(), 2u);
  for (const RunSummary& run : runs) {
    EXPECT_EQ(run.command, "study");
    EXPECT_EQ(run.answer, "The study is not finished.");
    EXPECT_EQ(run.verdict, "") << "it has none yet";
  }
  EXPECT_EQ(runs[0].page, "");
  EXPECT_EQ(runs[1].twin, "Study “ball”");
  EXPECT_THAT(index(), HasSubstr("<a href=\"stopped/unfinished.html\">stopped</a>"));
}

TEST_F(RunIndex, PagesWithNamesOfTheirOwnHaveRowsWithoutAVerdict) {
  write_titled_page("both/calibration.html", "Calibration");
  write_titled_page("both/photometry.html", "Photometry");
  write_titled_page("cost/needs.html", "What “a rig” needs");
  write("cost/pareto.html", "<html><header><h1>mine</h1></header></html>");
  write_page("cost", "Twin and rig agree.");
  const std::vector<RunSummary> runs = runs_below(dir_);
  ASSERT_EQ(runs.size(), 4u);
  EXPECT_EQ(runs[0].command, "photometry");
  EXPECT_EQ(runs[0].answer, "Photometry");
  EXPECT_EQ(runs[1].command, "calibrate");
  EXPECT_EQ(runs[1].verdict, "");
  EXPECT_EQ(runs[2].answer, "Twin and rig agree.") << "the run comes first";
  EXPECT_EQ(runs[3].command, "needs");
  EXPECT_EQ(runs[3].answer, "What “a rig” needs");
  EXPECT_THAT(index(), HasSubstr("<a href=\"both/calibration.html\">both</a>"));
  EXPECT_THAT(index(), HasSubstr("<a href=\"cost/needs.html\">cost</a>"));
}

TEST_F(RunIndex, WhatCannotBeReadIsARowThatSaysSo) {
  write("broken/result.json", "{\"schema\":");
  write("foreign/result.json", "[1, 2]");
  write("odd/result.json",
        R"({"schema": "fringetwin-result/1", "twin": 3, "gain": {"a": 1}, "phase": [7, {"rms_rad": "x"}],
            "held_out": "none", "provenance": {"argv": [1, 2]}})");
  const std::vector<RunSummary> runs = runs_below(dir_);
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_THAT(runs[0].fault, HasSubstr("broken/result.json"));
  EXPECT_THAT(runs[1].fault, HasSubstr("this is no fringetwin result"));
  EXPECT_EQ(runs[2].fault, "");
  EXPECT_EQ(runs[2].command, "");
  EXPECT_TRUE(std::isnan(runs[2].phase_rms_rad));
  EXPECT_THAT(index(), HasSubstr("this is no fringetwin result"));
}

TEST_F(RunIndex, NamesOfFoldersAreTextAndAddressesOnly) {
  const std::string script = "<script>alert(1)<", colon = "javascript:alert(1)";
  for (const std::string& name : {script, colon}) {
    write(fs::path(name) / "result.json", kResult);
    write_page(name, "a </td><script>x");
  }
  write(".unseen_run/result.json", kResult);
  fs::create_directory_symlink(dir_, dir_ / "loop_to_itself");
  const std::string html = index();
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)&lt;</a>"));
  EXPECT_THAT(html, HasSubstr("href=\"%3Cscript%3Ealert%281%29%3C/report.html\""));
  EXPECT_THAT(html, HasSubstr("href=\"javascript%3Aalert%281%29/report.html\""));
  EXPECT_THAT(html, Not(HasSubstr("unseen_run")));
  EXPECT_THAT(html, Not(HasSubstr("loop_to_itself")));
}

TEST_F(RunIndex, KnowsItsOwnPage) {
  write("index.html", index());
  EXPECT_TRUE(is_run_index(dir_ / "index.html"));
  write_page(".", "an answer");
  EXPECT_FALSE(is_run_index(dir_ / "report.html")) << "a page of ours, but no index";
  write("mine.html", "<title>Runs of fringetwin</title><h1>Runs of fringetwin</h1>");
  EXPECT_FALSE(is_run_index(dir_ / "mine.html"));
  EXPECT_FALSE(is_run_index(dir_));
  EXPECT_THAT(index(), HasSubstr("<a href=\"report.html\">.</a>")) << "the folder itself is a run";
}

}  // namespace
}  // namespace fringetwin::compare::run_index_test
