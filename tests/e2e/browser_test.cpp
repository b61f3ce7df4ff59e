// SPDX-License-Identifier: Apache-2.0
// Comparison and study pages in a browser: what moves moves, they print, they load nothing.
//
// | check                  | limit | origin                                                        |
// |------------------------|-------|---------------------------------------------------------------|
// | contrast of words      | AA    | WCAG 2.1, 1.4.3: 4.5 : 1, of large words 3 : 1                |
// | width of a phone       | 400 px| asked for                                                     |
// | cloud fills the canvas | 5 %   | the sphere's cap is fitted to the canvas; axes alone are 0.1 % |
// | colours on the canvas  | 20    | 253 levels of the scale; a blank canvas has 1                 |
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::browser_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool have_program(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

#define FT_NEED_BROWSER()                                                                        \
  for (const char* program : {"chromium", "chromedriver", "python3"})                            \
    if (!have_program(program)) {                                                                \
      ASSERT_EQ(std::getenv("CI"), nullptr) << "no " << program << " in CI";                     \
      ASSERT_EQ(std::getenv("FRINGETWIN_REQUIRE_DEVICE"), nullptr) << "no " << program;          \
      GTEST_SKIP() << "SKIPPED: no " << program << " (packages.txt: chromium, chromium-driver)"; \
    }

/// A report with both sides: the small rig against its own noisy images of another exposure.
fs::path small_report() {
  const fs::path dir = scratch_folder("browser");
  const std::string sphere_fit = "[real]\ncaptures = \"real\"\n";
  EXPECT_EQ(
      render_twin(small_twin({{"gain_dn = 20", "gain_dn = 17\nelectrons_per_dn = 40\nread_noise_dn = 0.5"}}),
                  dir / "rig")
          .exit_code,
      0);
  fs::rename(dir / "rig" / "out", dir / "real");
  write_file(dir / "twin.toml", small_twin({}, sphere_fit));
  const RunResult run =
      run_fringetwin({"cosim", (dir / "twin.toml").string(), "--out", (dir / "report").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return dir / "report" / "report.html";
}

/// What browser_check.py saw.
json look_at(const fs::path& report) {
  const fs::path script = fs::path(std::getenv("FRINGETWIN_SOURCE")) / "tests" / "e2e" / "browser_check.py";
  const fs::path seen = report.parent_path() / "seen.json";
  const char* shots = std::getenv("FRINGETWIN_KEEP");  // a folder for screenshots
  const std::string command = "timeout 100 python3 '" + script.string() + "' '" + report.string() + "' " +
                              (shots ? "'" + std::string(shots) + "'" : "") + " >'" + seen.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return read_json(seen);
}

/// The share of a picture that clip-path leaves out on the left, in percent: "inset(0px 0px 0px 50%)".
double cut_percent(const std::string& clip) {
  const auto at = clip.rfind(' ');
  return at == std::string::npos ? -1.0 : std::strtod(clip.c_str() + at, nullptr);
}

/// Everyone can read it: by day, at night, on a phone, and those who hear it.
void expect_readable(const json& seen) {
  EXPECT_EQ(seen["overflow_px"], 0);  // nothing to scroll sideways
  EXPECT_EQ(seen["narrow_overflow_px"], 0);
  EXPECT_EQ(seen["pictures_without_words"], json::array());
  for (const char* scheme : {"light", "dark"}) {
    EXPECT_GT(seen[scheme]["words"].get<int>(), 50);
    EXPECT_EQ(seen[scheme]["faint"], json::array()) << scheme;
  }
  EXPECT_NE(seen["light"]["back"], seen["dark"]["back"]);
}

TEST(Browser, ThePageMovesPrintsAndLoadsNothing) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  const fs::path report = small_report();
  const json seen = look_at(report);
  SCOPED_TRACE(seen.dump(1));
  EXPECT_EQ(seen["title"], "small");
  expect_readable(seen);
  EXPECT_EQ(seen["console"], json::array());

  const json& slider = seen["slider"];
  EXPECT_EQ(slider["before"]["value"], 50);
  EXPECT_DOUBLE_EQ(cut_percent(slider["before"]["clip"]), 50.0);
  EXPECT_NEAR(slider["after"]["value"].get<double>(), 80.0, 2.0);  // pulled by 30 % of its width
  EXPECT_DOUBLE_EQ(cut_percent(slider["after"]["clip"]), slider["after"]["value"].get<double>());

  const json& cloud = seen["cloud"];
  EXPECT_GT(cloud["first"]["drawn"].get<double>(), 0.05);
  EXPECT_GT(cloud["first"]["colors"].get<int>(), 20);
  EXPECT_NE(cloud["turned"]["hash"], cloud["first"]["hash"]);
  EXPECT_GT(cloud["turned"]["drawn"].get<double>(), 0.05);
  EXPECT_LT(cloud["farther"]["drawn"].get<double>(), 0.7 * cloud["turned"]["drawn"].get<double>());
  EXPECT_EQ(cloud["again"]["hash"], cloud["first"]["hash"]);

  const json canvas = {{"canvas", true}, {"still", false}}, still = {{"canvas", false}, {"still", true}};
  EXPECT_EQ(seen["screen"], canvas);
  EXPECT_EQ(seen["print"], still);
  EXPECT_EQ(seen["no_script"], still);

  EXPECT_GT(seen["pdf"]["pages"].get<int>(), 1);
  EXPECT_GT(seen["pdf"]["bytes"].get<int>(), 100'000);

  const auto requests = seen["requests"].get<std::vector<std::string>>();
  EXPECT_THAT(requests,
              ::testing::Contains(::testing::EndsWith("report.html")));  // the log does see requests
  for (const std::string& url : requests)
    EXPECT_TRUE(url.starts_with("file://") || url.starts_with("data:")) << url;
}

TEST(Browser, TheIndexOfRuns) {
  FT_NEED_BROWSER();
  const fs::path dir = scratch_folder("browser_index");
  for (int i = 0; i < 6; ++i)
    write_file(
        dir / ("a_run_with_a_rather_long_name_" + std::to_string(i)) / "result.json",
        R"({"schema": "fringetwin-result/1", "twin": "two spheres on a wall", "phase": [{"rms_rad": 0.0123}],
                   "provenance": {"argv": ["fringetwin", "cosim"]}, "gain": [{"gain_dn": 17.3, "gain_sigma_dn": 0.1}]})");
  write_file(dir / "broken" / "result.json", "{");
  ASSERT_EQ(run_fringetwin({"index", dir.string()}).exit_code, 0);
  const json seen = look_at(dir / "index.html");
  SCOPED_TRACE(seen.dump(1));
  EXPECT_EQ(seen["title"], "Runs of fringetwin");
  expect_readable(seen);
  EXPECT_EQ(seen["console"], json::array());
}

/// A study of each kind on the small twin; `rows` of the page's drawings at least.
fs::path study_report(const std::string& name, const std::string& study) {
  const fs::path dir = scratch_folder("browser_" + name);
  write_file(dir / "twin.toml",
             small_twin({{"gain_dn = 20", "gain_dn = 20\nread_noise_dn = 1\nexposure_ms = 10"}}));
  write_file(dir / "STUDY.toml",
             "schema = \"fringetwin-study/1\"\nname = \"a <b>\"\ntwin = \"twin.toml\"\n" + study);
  fs::create_directories(dir / "out/figures");
  write_file(dir / "out/figures/earlier.svg",  // of an earlier run: goes
             "<svg role=\"img\"><g id=\"earlier-gnuplot_canvas\"></g></svg>");
  const RunResult run =
      run_fringetwin({"study", (dir / "STUDY.toml").string(), "--out", (dir / "out").string(), "--figures"});
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 5) << run.err;  // 5: not converged
  EXPECT_THAT(run.err, ::testing::HasSubstr("page: " + (dir / "out/report.html").string()));
  return dir / "out" / "report.html";
}

/// Nothing loaded, nothing to scroll sideways, a clean console, a page that prints; returns what was seen.
void expect_quiet_page(const fs::path& report, int drawings) {
  const json seen = look_at(report);
  SCOPED_TRACE(seen.dump(1));
  EXPECT_EQ(seen["title"], "Study “a <b>”");
  expect_readable(seen);
  EXPECT_EQ(seen["console"], json::array());
  EXPECT_EQ(seen["images"], drawings);
  EXPECT_GT(seen["pdf"]["pages"].get<int>(), 1);
  for (const std::string& url : seen["requests"].get<std::vector<std::string>>())
    EXPECT_TRUE(url.starts_with("file://") || url.starts_with("data:")) << url;
  const auto files = std::distance(fs::directory_iterator(report.parent_path() / "figures"), {});
  EXPECT_EQ(files, drawings);
  EXPECT_THAT(read_file(report), ::testing::Not(::testing::HasSubstr("class=\"missing")));
}

TEST(Browser, TheReportOfADesign) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  // mean and sigma of two numbers against two parameters and their pair, and two of the time
  expect_quiet_page(study_report("design", R"(noise_seeds = 3
[[vary]]
key = "camera.left.sensor.read_noise_dn"
range = [0.5, 8]
count = 3
scale = "log"
[[vary]]
key = "fringes.steps"
values = [3, 6]
[[record]]
result = "fits.ball.measured.radius_mm"
[[record]]
result = "acquisition.time_s"
name = "time_s"
)"),
                    6 + 3 + 2);
}

TEST(Browser, TheReportOfAMonteCarloStudy) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  // histogram, mean, sigma, tornado
  expect_quiet_page(study_report("monte_carlo", R"(kind = "monte-carlo"
block_trials = 10
least_blocks = 2
most_trials = 40
sensitivity_rows = 10
[[uncertain]]
key = "object.ball.center_mm[2]"
sigma = 0.05
[[record]]
result = "fits.ball.measured.center_mm[2]"
)"),
                    4);
}

TEST(Browser, TheReportOfAVolumeMap) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  // mean and sigma of six numbers in two slices, spacing
  expect_quiet_page(study_report("volume_map", R"(kind = "volume-map"
object = "ball"
center_mm = [0, 0, 270]
size_mm = [20, 10, 20]
counts = [2, 2, 2]
trials = 3
[[uncertain]]
key = "projector.rt_cam_world[1]"
sigma = 0.0001
)"),
                    24 + 2);
}

TEST(Browser, TheReportOfASearch) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  // progress, time against uncertainty, two parameters
  expect_quiet_page(study_report("optimise", R"(kind = "optimise"
evaluations = 12
trials = 3
[[choose]]
key = "projector.intensity"
range = [5, 50]
[[choose]]
key = "fringes.steps"
values = [3, 6]
[minimise]
result = "fits.ball.measured.radius_mm"
statistic = "sigma"
[[constraint]]
result = "images.left.saturated"
max = 0.05
)"),
                    4);
}

}  // namespace
}  // namespace fringetwin::testing::browser_test
