// SPDX-License-Identifier: Apache-2.0
// Options, output folders and exit codes of the built program. No tolerances: codes and sentences are exact.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "report/text.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::options_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

std::string written_twin(const fs::path& dir, const std::string& toml) {
  write_file(dir / "twin.toml", toml);
  return (dir / "twin.toml").string();
}

std::string results_with_radius(double radius_mm) {
  return "[real.results]\n[[real.results.fit]]\nobject = \"ball\"\nradius_mm = " + std::to_string(radius_mm) +
         "\n[limits]\nradius_mm = 0.5\n";
}

TEST(ExitCodes, LimitsMetIs0AndNotMetIs1) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("limits");
  for (const auto& [radius_mm, code, verdict] : {std::tuple{19.0, 0, "pass"}, std::tuple{21.0, 1, "fail"}}) {
    const std::string twin = written_twin(dir, small_twin({}, results_with_radius(radius_mm)));
    const RunResult run = run_fringetwin({"cosim", twin, "--out", (dir / "out").string()});
    EXPECT_EQ(run.exit_code, code) << run.err;
    const auto result = read_json(dir / "out" / "result.json");
    EXPECT_EQ(result["verdict"], verdict);
    ASSERT_EQ(result["limits"].size(), 1u);
    EXPECT_EQ(result["limits"][0]["pass"], code == 0);
  }
}

TEST(ExitCodes, OutputThatCannotBeWrittenIs3) {
  const auto dir = scratch_folder("full");
  const std::string result = (dir / "result.json").string(), err = (dir / "err").string();
  write_file(result, R"({"schema": "fringetwin-result/1"})");
  const char* program = std::getenv("FRINGETWIN_BINARY");
  ASSERT_NE(program, nullptr);
  for (const std::vector<std::string>& command : {std::vector<std::string>{"info"},
                                                  {"info", "--json"},
                                                  {"diff", result, result},
                                                  {"--help"},
                                                  {"--version"}}) {
    std::vector<std::string> words{program};
    words.insert(words.end(), command.begin(), command.end());
    const int status = std::system((report::shell_command(words) + " >/dev/full 2>" + err).c_str());
    EXPECT_EQ(WEXITSTATUS(status), 3) << command.front();
    EXPECT_THAT(read_file(err), HasSubstr("No space left on device")) << command.front();
  }
}

TEST(Sentences, AreOneLineThatSteersNothing) {
  const RunResult odd = run_fringetwin({"render", "a\x1b[2J\n\xc2\x9b.toml", "--out", "never"});
  expect_refused(odd, 2, {"fringetwin: error: a?[2J ?.toml: no such file"});
  EXPECT_EQ(std::ranges::count(odd.err, '\n'), 1);
  std::string path = "/begin";
  for (int i = 0; i < 400; ++i) path += "/folder";
  const RunResult cut = run_fringetwin({"render", path + "/twin.toml", "--out", "never"});
  expect_refused(cut, 2, {"error: /begin/folder/", "...", "/folder/twin.toml: no such file"});
  EXPECT_LE(cut.err.size(), 501u);
  expect_refused(run_fringetwin({"render", "fr\xe4se.toml", "--out", "never"}), 2,
                 {"fr?se.toml: is no UTF-8"});
  const RunResult option = run_fringetwin({"render", "--\x1b[2J"});
  EXPECT_EQ(option.exit_code, 2);
  EXPECT_EQ(option.err.find('\x1b'), std::string::npos);
}

TEST(Limits, AreRaisedByOneOption) {
  const auto dir = scratch_folder("raised");
  std::string many = "[render]\nsamples = [";
  for (int i = 0; i < 1'000'000; ++i) many += "0,";
  const std::string twin = written_twin(dir, small_twin({}, many + "]\n")), out = (dir / "out").string();
  expect_refused(run_fringetwin({"render", twin, "--out", out}), 2,
                 {"more than 1000000 keys and values", "--limits 10"});
  expect_refused(run_fringetwin({"render", twin, "--out", out, "--limits", "10"}), 2,
                 {"samples must be an integer"});
  for (const char* factor : {"0", "-1", "0.5", "inf", "1e300", "many"})
    EXPECT_EQ(run_fringetwin({"--limits", factor, "info"}).exit_code, 2) << factor;
}

// The same sentence and code from every command, before the work: no device is needed.
TEST(OutFolder, ThatCannotBeMadeIsExitCode2) {
  const auto dir = scratch_folder("blocked");
  const std::string twin = written_twin(dir, small_twin());
  write_file(dir / "file", "in the way");
  const std::string no_device = "VK_ICD_FILENAMES=/nonexistent.json";
  for (const std::string& out : {(dir / "file").string(), (dir / "file" / "below").string()})
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"render", twin},
          {"cosim", twin},
          {"measure", twin, "--captures", dir.string()},
          {"compare", twin, "--real", dir.string(), "--sim", dir.string()},
          {"photometry", twin, "--captures", dir.string()},
          {"import", "kalibr", twin},
          {"import", "opencv", twin, "--camera", "left=M,D@64x48"}}) {
      std::vector<std::string> args = command;
      args.insert(args.end(), {"--out", out});
      expect_refused(run_fringetwin(args, {no_device}), 2,
                     {"--out " + out + ": ", "is no folder", "choose a folder"});
    }
  EXPECT_EQ(read_file(dir / "file"), "in the way");
}

TEST(OutFolder, OfARunThatFailsIsNotMade) {
  const auto dir = scratch_folder("not-made");
  const std::string twin = written_twin(dir, small_twin({{"radius_mm = 19", "radius_mm = 0"}}));
  EXPECT_EQ(run_fringetwin({"render", twin, "--out", (dir / "out").string()}).exit_code, 2);
  EXPECT_FALSE(fs::exists(dir / "out"));
}

// A second run that breaks off between its images must not leave the first run's capture.toml on a mix.
TEST(OutFolder, ABrokenOffRunDoesNotLookComplete) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("broken-off");
  ASSERT_EQ(render_twin(small_twin(), dir).exit_code, 0);
  ASSERT_TRUE(fs::exists(dir / "out" / "capture.toml"));
  fs::remove(dir / "out" / "left" / "0007.png");
  write_file(dir / "out" / "left" / "0007.png" / "x", "no image can replace this folder");
  EXPECT_EQ(render_twin(small_twin({{"radius_mm = 19", "radius_mm = 18"}}), dir).exit_code, 2);
  EXPECT_FALSE(fs::exists(dir / "out" / "capture.toml"));
}

TEST(Render, RefusesFringesThatCannotBeUnwrappedBeforeTheWork) {
  const auto dir = scratch_folder("infeasible");
  expect_refused(render_twin(small_twin({{"[13, 14, 15]", "[10, 20, 30]"}}), dir), 2,
                 {"the pitches 10, 20, 30 repeat after", "does not cover the projector's 1280 px"});
  EXPECT_FALSE(fs::exists(dir / "out"));
}

TEST(Render, RecordsTheExposure) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("exposure");
  ASSERT_EQ(render_twin(small_twin({{"gain_dn = 20", "gain_dn = 20\nexposure_ms = 12.5"}}), dir).exit_code,
            0);
  EXPECT_THAT(read_file(dir / "out" / "capture.toml"), HasSubstr("\"exposure_ms left\" = \"12.5\""));
}

TEST(MeasuredObject, StepsThatLeaveNothingToCompareAreRefusedBeforeTheWork) {
  const auto dir = scratch_folder("left-over");
  const std::string sphere = "shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19";
  const std::string real = "[real]\ncaptures = \"real\"\n";
  const std::string five =
      written_twin(dir, small_twin({{"steps = 4", "steps = 5"}, {sphere, "shape = \"measured\""}}, real));
  expect_refused(run_fringetwin({"cosim", five, "--out", (dir / "out").string()}), 2,
                 {"leave 2 of the 5 phase steps"});
  const std::string both = written_twin(
      dir, small_twin({{"steps = 4", "steps = 8"}, {sphere, "shape = \"measured\""}},
                      "[[object]]\nname = \"two\"\nshape = \"measured\"\nsteps = \"odd\"\n" + real));
  expect_refused(run_fringetwin({"compare", both, "--real", dir.string(), "--sim", dir.string(), "--out",
                                 (dir / "out").string()}),
                 2, {"\"two\"", "leave 0 of the 8 phase steps"});
}

TEST(Options, ValuesOutOfRange) {
  const auto dir = scratch_folder("options");
  const std::string twin = written_twin(dir, small_twin()), out = (dir / "out").string();
  for (const auto& [option, value] :
       {std::pair{"--seed", "-1"}, std::pair{"--seed", "x"}, std::pair{"--phase-error", "1e-12"},
        std::pair{"--phase-error", "0"}, std::pair{"--phase-error", "10"}, std::pair{"--samples", "many"}}) {
    const RunResult run = run_fringetwin({"render", twin, "--out", out, option, value});
    EXPECT_EQ(run.exit_code, 2) << option << " " << value << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr(option));
  }
  EXPECT_FALSE(fs::exists(out));
}

TEST(CommandLine, NamesWhatWasMeant) {
  for (const auto& [words, sentence] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"cosin", "twin.toml"}, "cosin: no such command; did you mean \"cosim\"?"},
           {{"import", "opnecv"}, "import opnecv: no such command; did you mean \"opencv\"?"},
           {{"help", "mesure"}, "mesure: no such command; did you mean \"measure\"?"},
           {{"cosim", "a", "--ouput", "b"}, "cosim --ouput: no such option; did you mean \"--out\"?"},
           {{"cosim", "a", "--output=b"}, "cosim --output: no such option; did you mean \"--out\"?"},
           {{"measure", "a", "--out", "b"}, "measure: --captures DIR is missing; fringetwin measure"},
           {{"diff", "a"}, "diff: RUN_B is missing; fringetwin diff RUN_A RUN_B"},
           {{"render", "--out"}, "render: --out DIR has no value"},
           {{"render", "--out", "--seed", "5"}, "render: --out DIR has no value"},
           {{"render", "a", "--out", "-q"}, "render: --out DIR has no value"},
           {{"import", "--map", "a=b", "captures"},
            "import --map: is an option of commands; it stands behind"},
           {{"new", "--from", "--out", "q"}, "new: --from FILE has no value"},
           {{"new", "--sphere", "30"}, "new --sphere: no such option; `fringetwin help new` lists them"},
           {{"--ouput", "q"}, "fringetwin --ouput: no such option; did you mean \"--out\"?"},
           {{"--captures", "q", "measure"}, "--captures: is an option of commands; it stands behind"},
           {{"render", "a", "--samples", "many"}, "render --samples: \"many\" is no number"},
           {{"render", "a", "--samples", "1.5"}, "render --samples: \"1.5\" is no whole number"},
           {{"info", "x"}, "info: \"x\" is one argument too many"},
           {{"new", "--from", "a", "--from", "b", "--from", "c"}, "new: --from FILE has 3 values, at most 2"},
           {{"index", ""}, "\"\": one of the arguments is empty"},
           {{}, "fringetwin: no command given"}}) {
    const RunResult run = run_fringetwin(words);
    expect_refused(run, 2, {sentence});
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1);
  }
}

TEST(CommandLine, HelpAndVersionAreCommands) {
  const std::string version = run_fringetwin({"--version"}).out;
  EXPECT_EQ(run_fringetwin({"version"}).out, version);
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  ASSERT_NE(source, nullptr);
  const bool checkout = fs::exists(fs::path(source) / ".git");
  const std::string commit = checkout ? "[0-9a-f]{12,40}(-dirty)?, " : "";
  EXPECT_THAT(version, ::testing::MatchesRegex("[0-9]+[.][0-9]+[.][0-9]+ [(]" + commit +
                                               "[A-Za-z]+, g[+][+] .*[)]\n"));
  for (const std::vector<std::string>& path :
       {std::vector<std::string>{}, {"measure"}, {"import"}, {"import", "opencv"}}) {
    std::vector<std::string> help{"help"}, flag = path;
    help.insert(help.end(), path.begin(), path.end());
    flag.emplace_back("--help");
    const RunResult run = run_fringetwin(help);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out, run_fringetwin(flag).out);
    EXPECT_THAT(run.out, HasSubstr("Usage: fringetwin"));
  }
}

// Every value has a name that says what it is, not how the program keeps it.
TEST(CommandLine, HelpNamesValuesAndDefaults) {
  for (const char* command : {"cosim", "render", "measure", "compare", "diff", "calibrate", "photometry",
                              "capture", "needs", "pareto", "study", "info"}) {
    const std::string page = run_fringetwin({command, "--help"}).out;
    for (const char* type : {" TEXT", " INT", " UINT", " FLOAT"})
      EXPECT_THAT(page, Not(HasSubstr(type))) << command;
  }
  for (const char* command : {"opencv", "kalibr", "matrices", "mrcal", "captures"})
    EXPECT_THAT(run_fringetwin({"import", command, "--help"}).out, Not(HasSubstr(" TEXT"))) << command;
  const std::string needs = run_fringetwin({"needs", "--help"}).out;
  EXPECT_THAT(needs, HasSubstr("--windows N"));
  EXPECT_THAT(needs, HasSubstr("(1 ... 10000; default: 12)"));
  EXPECT_THAT(needs, HasSubstr("--limits FACTOR"));
}

TEST(CommandLine, AFolderStandsForItsTwin) {
  const auto dir = scratch_folder("folder");
  written_twin(dir, small_twin({{"radius_mm = 19", "radius_mm = 0"}}));
  expect_refused(run_fringetwin({"render", dir.string(), "--out", (dir / "out").string()}), 2,
                 {(dir / "twin.toml").string(), "radius_mm"});
}

TEST(CommandLine, JsonIsWhatTheFileHoldsAndNothingElse) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("json");
  const std::string twin = written_twin(dir, small_twin());
  const auto expect_printed = [&](std::vector<std::string> words, const std::string& file) {
    const std::string out = (dir / "out").string();
    words.insert(words.end(), {"--json", "--out", out});
    const RunResult run = run_fringetwin(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out, read_file(fs::path(out) / file)) << words[0];
    EXPECT_TRUE(nlohmann::json::parse(run.out).contains("schema")) << words[0];
  };
  expect_printed({"cosim", twin}, "result.json");
  const std::string simulated = (dir / "out" / "simulated").string();
  expect_printed({"measure", twin, "--captures", simulated}, "result.json");
  fs::rename(simulated, dir / "set");
  expect_printed({"compare", twin, "--real", (dir / "set").string(), "--sim", (dir / "set").string()},
                 "result.json");
  expect_printed({"pareto", twin, "--quick"}, "pareto.json");
}

TEST(Export, WritesTheTablesOfAResult) {
  const auto dir = scratch_folder("export");
  write_file(dir / "result.json",
             R"({"schema": "fringetwin-result/1", "fits": [{"object": "ball", "radius_mm": 20.5}]})");
  const RunResult run = run_fringetwin({"export", dir.string(), "--out", (dir / "tables").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, (dir / "tables" / "fits.csv").string() + "\n");
  EXPECT_EQ(read_file(dir / "tables" / "fits.csv"), "object,radius_mm\r\nball,20.5\r\n");
  expect_refused(run_fringetwin({"export", (dir / "none").string(), "--out", (dir / "never").string()}), 3,
                 {"none", "give the folder of a run, or its result.json"});
  EXPECT_FALSE(fs::exists(dir / "never"));
  write_file(dir / "result.json", R"({"schema": "fringetwin-result/1", "../beside": [{"a": 1}]})");
  expect_refused(run_fringetwin({"export", dir.string(), "--out", (dir / "never").string()}), 3,
                 {"\"../beside\" is no name of a table"});
  EXPECT_FALSE(fs::exists(dir / "beside.csv"));
}

TEST(Export, WritesTheDrawingsOfAPage) {
  const auto dir = scratch_folder("export_figures");
  const std::string drawing = "<svg role=\"img\"><g id=\"gray-left0-gnuplot_canvas\"></g></svg>";
  write_file(dir / "result.json", R"({"schema": "fringetwin-result/1", "fits": [{"object": "ball"}]})");
  const auto exported = [&](const fs::path& run, const char* out) {
    return run_fringetwin({"export", run.string(), "--figures", "--out", (dir / out).string()});
  };
  expect_refused(exported(dir, "never"), 3, {"report.html"});
  write_file(dir / "report.html", "<html><p>nothing drawn</p></html>");
  expect_refused(exported(dir, "never"), 3, {"report.html", "has no drawings"});
  EXPECT_FALSE(fs::exists(dir / "never"));
  write_file(dir / "report.html", "<html>" + drawing + "</html>");
  const std::string svg = (dir / "out" / "gray-left0.svg").string();
  const RunResult run = exported(dir / "result.json", "out");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, (dir / "out" / "fits.csv").string() + "\n" + svg + "\n");
  EXPECT_THAT(read_file(svg), HasSubstr("<rect width=\"100%\""));
  write_file(dir / "photometry.html", "<html>" + drawing + "</html>");
  const RunResult page = exported(dir / "photometry.html", "page");
  EXPECT_EQ(page.exit_code, 0) << page.err;
  EXPECT_EQ(page.out, (dir / "page" / "gray-left0.svg").string() + "\n");
  expect_refused(
      run_fringetwin({"export", (dir / "photometry.html").string(), "--out", (dir / "never").string()}), 2,
      {"a page has no tables", "--figures"});
}

// Folders of needs, pareto, photometry, calibrate and of studies have a page, and no table of a comparison.
TEST(Export, FindsThePageOfAFolderWithoutAResult) {
  const auto dir = scratch_folder("export_page_alone");
  const auto exported = [&](const fs::path& run, std::vector<std::string> more) {
    more.insert(more.begin(), {"export", run.string(), "--out", (dir / "out").string()});
    return run_fringetwin(more);
  };
  for (const char* name : {"needs", "pareto", "photometry", "calibration"}) {
    write_file(
        dir / name / (std::string(name) + ".html"),
        "<html><svg role=\"img\"><g id=\"" + std::string(name) + "-gnuplot_canvas\"></g></svg></html>");
    const RunResult run = exported(dir / name, {"--figures"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out, (dir / "out" / (std::string(name) + ".svg")).string() + "\n");
    expect_refused(exported(dir / name, {}), 2, {name, "holds no result of cosim", "--figures exports"});
  }
  write_file(dir / "study" / "study.db", "");
  write_file(dir / "study" / "result.json", R"({"schema": "fringetwin-monte-carlo/1"})");
  expect_refused(exported(dir / "study", {"--figures"}), 3, {"has no page yet", "--so-far` makes one"});
  write_file(dir / "study" / "unfinished.html", read_file(dir / "needs" / "needs.html"));
  EXPECT_EQ(exported(dir / "study", {"--figures"}).exit_code, 0);
  expect_refused(exported(dir / "study", {}), 2, {"the table of a study is its study.csv"});
}

TEST(Export, NamesTheToolThatDidNotDrawThePage) {
  const auto dir = scratch_folder("export_undrawn");
  write_file(dir / "result.json", R"({"schema": "fringetwin-result/1", "fits": [{"object": "ball"}]})");
  const std::string drawing = "<svg role=\"img\"><g id=\"gray-left0-gnuplot_canvas\"></g></svg>",
                    undrawn = "<p class=\"missing undrawn\">Plot left out: gnuplot: is not there.</p>";
  const auto exported = [&] {
    return run_fringetwin({"export", dir.string(), "--figures", "--out", (dir / "out").string()});
  };
  write_file(dir / "report.html", "<html>" + undrawn + undrawn + "</html>");
  expect_refused(exported(), 2, {"2 of its drawings could not be made (gnuplot: is not there)"});
  EXPECT_FALSE(fs::exists(dir / "out"));
  write_file(dir / "report.html", "<html>" + undrawn + drawing + "</html>");
  expect_refused(exported(), 2, {"1 of its drawings could not be made"});
  EXPECT_TRUE(fs::exists(dir / "out" / "gray-left0.svg")) << "what is there is written";
}

TEST(Index, ListsTheRunsBelowAFolder) {
  const auto dir = scratch_folder("index");
  const auto index = [&](const fs::path& of) { return run_fringetwin({"index", of.string()}); };
  const fs::path page = dir / "index.html";
  expect_refused(index(dir / "none"), 3, {"none: is no folder"});
  expect_refused(index(dir), 3, {"no run is here or below"});
  EXPECT_FALSE(fs::exists(page));

  const std::string script = "<script>alert(1)<";
  for (const std::string& name : {std::string("plain"), script})
    write_file(dir / name / "result.json",
               R"({"schema": "fringetwin-result/1", "twin": "<script>", "phase": [{"rms_rad": 0.25}]})");
  write_file(dir / "broken" / "result.json", "{");
  const RunResult run = index(dir);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, page.string() + "\n");
  EXPECT_THAT(run.err, HasSubstr("3 runs listed"));
  const std::string html = read_file(page);
  EXPECT_THAT(html, HasSubstr("0.25000"));
  EXPECT_THAT(html, HasSubstr("broken/result.json"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));

  fs::remove_all(dir / "plain");
  EXPECT_EQ(index(dir).exit_code, 0) << "its own page is written anew";
  EXPECT_THAT(read_file(page), Not(HasSubstr("plain")));
  fs::remove_all(dir / "broken");
  fs::remove_all(dir / script);
  EXPECT_EQ(index(dir).exit_code, 0) << "and lists none where the runs are gone";
  EXPECT_THAT(read_file(page), HasSubstr("No run is here."));
  write_file(page, "<html>mine</html>");
  expect_refused(index(dir), 2, {"index.html: was not written by this command", "move it away"});
  EXPECT_EQ(read_file(page), "<html>mine</html>");
}

// Everything else is written, and a command that fails anyway keeps its exit code.
TEST(Figures, WithoutGnuplotTheRunSaysSoAndDoesNotEndWell) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("figures_without_gnuplot");
  const std::string twin = written_twin(dir, small_twin({}, results_with_radius(21.0)));
  fs::create_symlink("/usr/bin/timeout", dir / "timeout");  // which run_fringetwin() runs the program by
  const std::vector<std::string> no_gnuplot = {"PATH=" + dir.string()};
  ASSERT_EQ(run_fringetwin({"render", twin, "--out", (dir / "set").string()}).exit_code, 0);
  const std::vector<std::string> measure = {
      "measure", twin, "--captures", (dir / "set").string(), "--out", (dir / "measured").string()};
  EXPECT_EQ(run_fringetwin(measure, no_gnuplot).exit_code, 0) << "no files of plots are asked for";
  std::vector<std::string> with_figures = measure;
  with_figures.emplace_back("--figures");
  const RunResult run = run_fringetwin(with_figures, no_gnuplot);
  expect_refused(run, 2, {"drawings could not be made (gnuplot: ", "gnuplot-nox"});
  EXPECT_TRUE(fs::exists(dir / "measured" / "result.json"));
  EXPECT_TRUE(fs::exists(dir / "measured" / "points.ply"));
  const RunResult cosim =
      run_fringetwin({"cosim", twin, "--figures", "--out", (dir / "cosim").string()}, no_gnuplot);
  EXPECT_EQ(cosim.exit_code, 1) << "limits are not met: " << cosim.err;
  EXPECT_THAT(cosim.err, HasSubstr("warning: " + (dir / "cosim" / "report.html").string()));
  EXPECT_TRUE(fs::exists(dir / "cosim" / "result.json"));
}

// The program that shows pages is one of ours here: it writes down what it was given.
TEST(Open, ShowsThePageOfARun) {
  const auto dir = scratch_folder("open");
  fs::create_directories(dir / "bin");
  write_file(dir / "report.html", "<html></html>");
  write_file(dir / "bin" / "xdg-open", "#!/bin/sh\necho \"$1\" >\"$0.seen\"\n");
  fs::permissions(dir / "bin" / "xdg-open", fs::perms::owner_all);
  const RunResult shown =
      run_fringetwin({"open", dir.string()}, {"PATH=" + (dir / "bin").string() + ":" + std::getenv("PATH")});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_EQ(shown.out, (dir / "report.html").string() + "\n");
  EXPECT_EQ(read_file(dir / "bin" / "xdg-open.seen"), shown.out);
  const auto open_with = [&](const std::string& script) {
    write_file(dir / "bin" / "xdg-open", "#!/bin/sh\n" + script + "\n");
    return run_fringetwin({"open", dir.string()},
                          {"PATH=" + (dir / "bin").string() + ":" + std::getenv("PATH")});
  };
  expect_refused(open_with("exit 3"), 3, {"xdg-open: found no program for pages"});
  // one that stays in the foreground, as a browser does, is neither waited for nor stopped
  EXPECT_EQ(open_with("echo words; while ! test -e \"$0.go\"; do sleep 0.1; done; echo late >\"$0.late\"")
                .exit_code,
            0);
  EXPECT_FALSE(fs::exists(dir / "bin" / "xdg-open.late"));
  write_file(dir / "bin" / "xdg-open.go", "");
  for (int i = 0; i < 300 && !fs::exists(dir / "bin" / "xdg-open.late"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(fs::exists(dir / "bin" / "xdg-open.late"));
  fs::remove(dir / "report.html");
  expect_refused(run_fringetwin({"open", dir.string()}), 3, {"report.html: there is no such page"});
  write_file(dir / "study.db", "");
  expect_refused(run_fringetwin({"open", dir.string()}), 3,
                 {"the study is not finished and has no page yet",
                  "`fringetwin study STUDY.toml --out " + dir.string() + " --so-far` makes one"});
  for (const char* name : {"unfinished.html", "calibration.html", "photometry.html", "needs.html"}) {
    write_file(dir / name, "<html></html>");
    EXPECT_EQ(open_with("exit 0").out, (dir / name).string() + "\n");
  }
}

TEST(Options, QuietBeforeAndAfterTheSubcommand) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("quiet");
  // Its camera is so coarse that 3 rad of the fringe lie in a pixel: with the default target it warns, quiet
  // or not.
  const std::string twin = written_twin(dir, small_twin({}, "[render]\nphase_error_rad = 1e-3\n")),
                    out = (dir / "out").string();
  for (const std::vector<std::string>& args : {std::vector<std::string>{"-q", "render", twin, "--out", out},
                                               {"render", "-q", twin, "--out", out},
                                               {"render", twin, "--out", out, "--quiet"}}) {
    const RunResult run = run_fringetwin(args);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
  }
}

TEST(Options, VerboseNamesStagesTheirTimesAndFiles) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("verbose");
  const std::string twin = written_twin(dir, small_twin({}, "[render]\nphase_error_rad = 1e-3\n")),
                    out = (dir / "out").string();
  const RunResult plain = run_fringetwin({"render", twin, "--out", out}),
                  verbose = run_fringetwin({"render", "-v", twin, "--out", out});
  EXPECT_EQ(verbose.exit_code, 0) << verbose.err;
  EXPECT_EQ(verbose.out, plain.out);
  for (const std::string& words :
       {std::string("fringetwin: stage render\n"), std::string("fringetwin: stage render took "),
        "fringetwin: wrote " + out + "/capture.toml\n"}) {
    EXPECT_THAT(verbose.err, HasSubstr(words));
    EXPECT_THAT(plain.err, ::testing::Not(HasSubstr(words)));
  }
  expect_refused(run_fringetwin({"-q", "-v", "render", twin, "--out", out}), 2, {"--verbose"});
}

}  // namespace
}  // namespace fringetwin::testing::options_test
