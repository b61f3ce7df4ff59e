// SPDX-License-Identifier: Apache-2.0
// Pages of each kind in a browser: what moves moves, by mouse and by key, they print, they load nothing.
//
// | check                  | limit | origin                                                        |
// |------------------------|-------|---------------------------------------------------------------|
// | contrast of words      | AA    | WCAG 2.1, 1.4.3: 4.5 : 1, of large words 3 : 1                |
// | width of a phone       | 400 px| asked for                                                     |
// | letters of plots there | 9 px  | asked for; report::least_width_px leaves 9.2                  |
// | cloud fills the canvas | 5 %   | the sphere's cap is fitted to the canvas; axes alone are 0.1 % |
// | colours on the canvas  | 20    | 253 levels of the scale; a blank canvas has 1                 |
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "calib/board/corners_vnl.hpp"
#include "tests/support/calib/calib_rig.hpp"
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

/// Runs the program: what it makes is there.
void expect_made(const std::vector<std::string>& args) {
  const RunResult run = run_fringetwin(args);
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

/// A rig with noisy images of another exposure: DIR/twin.toml and DIR/real.
fs::path small_rig(const std::string& name) {
  const fs::path dir = scratch_folder(name);
  EXPECT_EQ(
      render_twin(small_twin({{"gain_dn = 20", "gain_dn = 17\nelectrons_per_dn = 40\nread_noise_dn = 0.5"}}),
                  dir / "rig")
          .exit_code,
      0);
  fs::rename(dir / "rig" / "out", dir / "real");
  write_file(dir / "twin.toml",
             small_twin({{"gain_dn = 20", "gain_dn = 20\nelectrons_per_dn = 40\nread_noise_dn = 0.5"}},
                        "[real]\ncaptures = \"real\"\n"));
  return dir;
}

/// A report with both sides.
fs::path small_report() {
  const fs::path dir = small_rig("browser");
  expect_made({"cosim", (dir / "twin.toml").string(), "--out", (dir / "report").string()});
  return dir / "report" / "report.html";
}

/// What browser_check.py saw of each page, in their order.
std::vector<json> look_at_all(const std::vector<fs::path>& pages) {
  const fs::path script = fs::path(std::getenv("FRINGETWIN_SOURCE")) / "tests" / "e2e" / "browser_check.py";
  const fs::path seen = pages.at(0).parent_path() / "seen.json";
  std::string command = "timeout 200 python3 '" + script.string() + "'";
  if (const char* folder = std::getenv("FRINGETWIN_KEEP"))
    command += " --shots '" + std::string(folder) + "'";
  for (const fs::path& page : pages) command += " '" + page.string() + "'";
  EXPECT_EQ(std::system((command + " >'" + seen.string() + "'").c_str()), 0) << command;
  auto all = read_json(seen).get<std::vector<json>>();
  EXPECT_EQ(all.size(), pages.size());
  all.resize(pages.size());
  return all;
}
json look_at(const fs::path& page) { return look_at_all({page}).at(0); }

/// The share of a picture that clip-path leaves out on the left, in percent: "inset(0px 0px 0px 50%)".
double cut_percent(const std::string& clip) {
  const auto at = clip.rfind(' ');
  return at == std::string::npos ? -1.0 : std::strtod(clip.c_str() + at, nullptr);
}

void expect_loads_nothing(const json& seen) {
  const auto requests = seen["requests"].get<std::vector<std::string>>();
  EXPECT_THAT(requests, ::testing::Contains(::testing::EndsWith(".html")));  // the log does see requests
  for (const std::string& url : requests)
    EXPECT_TRUE(url.starts_with("file://") || url.starts_with("data:")) << url;
}

/// Everyone can read it: by day, at night, on a phone, by key, and those who hear it. The console is clean.
void expect_readable(const json& seen) {
  EXPECT_EQ(seen["console"], json::array());
  EXPECT_EQ(seen["overflow_px"], 0);  // nothing to scroll sideways
  EXPECT_EQ(seen["narrow_overflow_px"], 0);
  EXPECT_EQ(seen["pictures_without_words"], json::array());
  EXPECT_EQ(seen["captions_cut"], json::array());
  EXPECT_EQ(seen["scrolled_without_keys"], json::array());
  EXPECT_EQ(seen["plots"]["small"], json::array());
  for (const auto& [kind, scrolled] : seen["scrolled_by_key"].items()) {
    if (scrolled.is_null()) continue;
    EXPECT_TRUE(scrolled["at"].is_string()) << "no Tab leads to a " << kind;
    EXPECT_GT(scrolled["px"].get<double>(), 0.0) << kind;
  }
  if (seen["images"].get<int>() > 0) {  // one at least is wider than a phone
    EXPECT_GT(seen["plots"]["texts"].get<int>(), 0);
    EXPECT_FALSE(seen["scrolled_by_key"]["drawing"].is_null());
  }
  for (const char* scheme : {"light", "dark"}) {
    EXPECT_GT(seen[scheme]["words"].get<int>(), 50);
    EXPECT_EQ(seen[scheme]["faint"], json::array()) << scheme;
  }
  EXPECT_NE(seen["light"]["back"], seen["dark"]["back"]);
}

/// Tab leads to the cloud, a slider and the words at the end; there keys do what the mouse does.
void expect_moved_by_keys(const json& seen) {
  for (const char* at : {"cloud_at", "slider_at", "words_at"}) EXPECT_TRUE(seen[at].is_string()) << at;
  const json& cloud = seen["cloud"];
  EXPECT_NE(cloud["right"]["hash"], cloud["first"]["hash"]);
  EXPECT_NE(cloud["down"]["hash"], cloud["right"]["hash"]);
  EXPECT_LT(cloud["farther"]["drawn"].get<double>(), 0.9 * cloud["down"]["drawn"].get<double>());
  EXPECT_EQ(cloud["again"]["hash"], cloud["first"]["hash"]);
  const json &before = seen["slider"]["before"], &after = seen["slider"]["after"];
  EXPECT_EQ(after["value"].get<double>(), before["value"].get<double>() - 10.0);  // ten arrows, 1 % each
  EXPECT_DOUBLE_EQ(cut_percent(after["clip"]), after["value"].get<double>());
  EXPECT_EQ(seen["words"], true);  // opened by Enter
}

TEST(Browser, ThePageMovesPrintsAndLoadsNothing) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  const fs::path report = small_report();
  const json seen = look_at(report);
  SCOPED_TRACE(seen.dump(1));
  EXPECT_EQ(seen["title"], "small");
  expect_readable(seen);

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
  expect_loads_nothing(seen);
  expect_moved_by_keys(seen["keyboard"]);
  EXPECT_FALSE(seen["scrolled_by_key"]["table"].is_null());  // on a phone some table is wider than the page
}

/// A measured object has no fitted points, so its comparison has a slider and no cloud.
TEST(Browser, TheReportOfAMeasuredObject) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  FT_NEED_CAPTURES("slmaster-mono-relief");
  const fs::path out = scratch_folder("browser_measured");
  expect_made({"cosim", dataset_twin("slmaster-mono-relief").string(), "--out", out.string()});
  const json seen = look_at(out / "report.html");
  SCOPED_TRACE(seen.dump(1));
  expect_readable(seen);
  expect_loads_nothing(seen);
  EXPECT_FALSE(seen.contains("cloud"));
  for (const char* at : {"slider_at", "words_at"}) EXPECT_TRUE(seen["keyboard"][at].is_string()) << at;
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

int count_of(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// Everyone can read it, nothing is loaded, it prints on `least_sheets` at least, no drawing is missing that
/// has data.
void expect_quiet_page(const json& seen, const fs::path& page, int least_sheets = 1) {
  SCOPED_TRACE(page.string() + seen.dump(1));
  expect_readable(seen);
  expect_loads_nothing(seen);
  EXPECT_GE(seen["pdf"]["pages"].get<int>(), least_sheets);
  const std::string html = read_file(page);
  EXPECT_EQ(count_of(html, "class=\"missing"), count_of(html, "there are no data to draw"));
}

/// A study's page is quiet, and has so many drawings, which are files, too.
void expect_study_page(const json& seen, const fs::path& report, int drawings) {
  expect_quiet_page(seen, report, 2);
  EXPECT_EQ(seen["title"], "Study “a <b>”");
  EXPECT_EQ(seen["images"], drawings);
  const auto files = std::distance(fs::directory_iterator(report.parent_path() / "figures"), {});
  EXPECT_EQ(files, drawings);
}
void expect_study_page(const fs::path& report, int drawings) {
  expect_study_page(look_at(report), report, drawings);
}

TEST(Browser, TheReportOfADesign) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  // mean and sigma of two numbers against two parameters and their pair, and two of the time
  expect_study_page(study_report("design", R"(noise_seeds = 3
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
  const fs::path report = study_report("monte_carlo", R"(kind = "monte-carlo"
block_trials = 10
least_blocks = 2
most_trials = 40
sensitivity_rows = 10
[[uncertain]]
key = "object.ball.center_mm[2]"
sigma = 0.05
[[record]]
result = "fits.ball.measured.center_mm[2]"
)");
  // as if it had been stopped just before it wrote its page
  const fs::path dir = report.parent_path(), so_far = dir / "unfinished.html", kept = dir / "kept.html";
  fs::rename(report, kept);
  expect_made({"study", (dir.parent_path() / "STUDY.toml").string(), "--out", dir.string(), "--so-far"});
  const std::vector<json> seen = look_at_all({kept, so_far});
  expect_study_page(seen[0], kept, 4);  // histogram, mean, sigma, tornado
  expect_quiet_page(seen[1], so_far);
  EXPECT_EQ(seen[1]["images"], 3);  // the tornado is of a finished study
}

TEST(Browser, TheReportOfAVolumeMap) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  // mean and sigma of six numbers in two slices, spacing
  expect_study_page(study_report("volume_map", R"(kind = "volume-map"
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
  expect_study_page(study_report("optimise", R"(kind = "optimise"
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

/// A sequence of one pitch, nothing measured: what is quick to render.
const std::pair<std::string, std::string> kOnePitch{"pitches_px = [13, 14, 15]\nsteps = 4",
                                                    "pitches_px = [30]\nsteps = 3\nunwrap = \"none\""},
    kNoFit{"triangulate = \"projector\"\n[[measure.fit]]\nobject = \"ball\"\n", ""};

fs::path effects_page(const std::string& command, const std::vector<std::string>& more) {
  const fs::path dir = scratch_folder("browser_" + command);
  write_file(dir / "twin.toml", small_twin({kOnePitch, kNoFit}));
  std::vector<std::string> args{command, (dir / "twin.toml").string(), "--out", (dir / "out").string()};
  args.insert(args.end(), more.begin(), more.end());
  expect_made(args);
  return dir / "out" / (command + ".html");
}

/// A tilted board that fills the image, of a sensor with shot noise.
fs::path photometry_page() {
  const fs::path dir = scratch_folder("browser_photometry");
  const std::string board = small_twin(
      {{"gain_dn = 20", "gain_dn = 20\nelectrons_per_dn = 30"},
       {"pitches_px = [13, 14, 15]\nsteps = 4", "pitches_px = [120, 15]\nsteps = 8\nunwrap = \"none\""},
       {"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19",
        "shape = \"plane\"\npoint_mm = [0, 0, 270]\nnormal = [0.6, 0.5, -1]"},
       kNoFit});
  EXPECT_EQ(render_twin(board, dir).exit_code, 0);
  expect_made({"photometry", (dir / "twin.toml").string(), "--captures", (dir / "out").string(), "--out",
               (dir / "found").string()});
  return dir / "found" / "photometry.html";
}

/// Two cameras and a projector before a few boards.
fs::path calibration_page() {
  const fs::path dir = scratch_folder("browser_calibrate");
  std::mt19937_64 random(31);
  const calib::Observations seen =
      draw_observations(true_paper_rig(), random, {.n_boards = 6, .least_corners = 60});
  calib::write_corners_vnl(dir / "corners.vnl", image_corners(seen));
  expect_made({"calibrate",
               "--corners-cache",
               (dir / "corners.vnl").string(),
               "--lensmodel",
               "LENSMODEL_OPENCV4",
               "--focal",
               "2000",
               "--imagersize",
               "1440x1080,1440x1080,1280x720",
               "--object-spacing",
               "0.012",
               "--object-width-n",
               "10",
               "--object-height-n",
               "8",
               "--names",
               "left,right,projector",
               "--outdir",
               (dir / "rig").string(),
               "left-*",
               "right-*",
               "projector-*"});
  return dir / "rig" / "calibration.html";
}

TEST(Browser, PagesOfAllOtherKinds) {
  FT_NEED_DEVICE();
  FT_NEED_BROWSER();
  const fs::path dir = small_rig("browser_kinds");
  const std::string twin = (dir / "twin.toml").string();
  expect_made({"measure", twin, "--captures", (dir / "real").string(), "--out", (dir / "measured").string()});
  expect_made({"cosim", twin, "--refine", "gain", "--hold-out", "4", "--out", (dir / "refined").string()});
  const std::vector<fs::path> pages{dir / "measured" / "report.html",
                                    dir / "refined" / "report.html",
                                    effects_page("needs", {"--rounds", "1", "--windows", "2"}),
                                    effects_page("pareto", {"--quick"}),
                                    calibration_page(),
                                    photometry_page()};
  const std::vector<json> seen = look_at_all(pages);
  for (std::size_t i = 0; i < pages.size(); ++i) expect_quiet_page(seen[i], pages[i], 2);
  // the pages are what they are meant to be
  const std::string refined = read_file(pages[1]);
  for (const char* id : {"id=\"refined\"", "id=\"held_out\""}) EXPECT_THAT(refined, ::testing::HasSubstr(id));
  expect_moved_by_keys(seen[1]["keyboard"]);
}

}  // namespace
}  // namespace fringetwin::testing::browser_test
