// SPDX-License-Identifier: Apache-2.0
// The page a user opens: complete, self-contained, small; sections vanish with their data.
#include "compare/page/report_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

#include "compare/pattern/pattern.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::report_page_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::SidesTruth;
using testing::SyntheticSides;

std::filesystem::path folder(const std::string& name) {
  const char* keep = std::getenv("FRINGETWIN_KEEP");  // a folder to look at the pages in
  const std::filesystem::path root = keep ? keep : std::filesystem::temp_directory_path();
  return root / ("fringetwin_report_" + name);
}

std::string write(const std::string& name, const SyntheticSides& scene, const CompareOptions& options = {},
                  const std::vector<PatternRow>& pattern = {}) {
  const auto dir = folder(name);
  Comparison c = compare(scene.twin, scene.real, scene.simulated, options);
  c.causes.pattern = pattern;
  const Provenance p{{"fringetwin", "cosim", "twin.toml", "--out", "my run"}, "0.1.0", {}, "llvmpipe", {}, 1};
  write_report(dir, scene.twin, scene.real, scene.simulated, c, options, p,
               {{"render", 1.2}, {"measure", 0.8}});
  std::ifstream in(dir / "report.html");
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Nothing is loaded from anywhere: no URL except the namespace names of SVG.
void expect_self_contained(std::string html) {
  html = std::regex_replace(html, std::regex("xmlns(:xlink)?=\"http://www.w3.org/[^\"]*\""), "");
  EXPECT_THAT(html, Not(HasSubstr("http://")));
  EXPECT_THAT(html, Not(HasSubstr("https://")));
  EXPECT_THAT(html, Not(HasSubstr("<link")));
  EXPECT_THAT(html, Not(HasSubstr("<script src")));
  EXPECT_THAT(html, Not(HasSubstr("@import")));
}

void expect_unique_ids(const std::string& html) {
  const std::regex id("\\sid=[\"']([^\"']+)[\"']");
  std::set<std::string> seen;
  for (std::sregex_iterator at(html.begin(), html.end(), id), end; at != end; ++at)
    EXPECT_TRUE(seen.insert((*at)[1]).second) << "id twice: " << (*at)[1];
}

TEST(ReportPage, HasEverySectionAndTheMaps) {
  SidesTruth t;
  t.cameras = 2;
  t.geometry_rad = 0.02;
  t.albedo_sigma = 0.02;
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.limits = {{"center_mm", 0.001}, {"phase_rms_rad", 0.001}};
  CompareOptions options;
  options.note = "What this comparison <can> show.";
  const std::string html = write("full", scene, options);
  std::size_t before = 0;
  for (const char* id : {"coverage", "fits", "gain", "images", "budget", "noise", "shift", "phase",
                         "deviation", "gray", "timing", "provenance"}) {
    const std::size_t at = html.find(std::string("id=\"") + id + "\"");
    ASSERT_NE(at, std::string::npos) << id;
    EXPECT_GT(at, before) << id;
    before = at;
  }
  EXPECT_LT(html.find("phase_rms_rad"), html.find("id=\"fits\""));  // the verdict comes first
  EXPECT_LT(html.find("<p class=\"answer\">Twin and rig agree in "), html.find("class=\"verdict"));
  EXPECT_LT(html.find("class=\"verdict"), html.find("What to do next:"));
  EXPECT_THAT(html, HasSubstr("class=\"verdict fail\""));
  EXPECT_THAT(html, HasSubstr("What this comparison &lt;can&gt; show."));
  EXPECT_THAT(html, HasSubstr("fringetwin cosim twin.toml --out &#39;my run&#39;"));
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr("sphere size: diameter − nominal"));
  expect_self_contained(html);
  expect_unique_ids(html);
  for (const char* file :
       {"coverage_left.png", "coverage_right.png", "gray_difference_left.png", "gray_difference_right.png",
        "phase_difference_left_x.png", "phase_difference_right_x.png", "deviation_ball_simulated.png",
        "deviation_ball_real.png"})
    EXPECT_TRUE(std::filesystem::exists(folder("full") / file)) << file;
}

TEST(ReportPage, PublishedNumbersOnlyShowsTheSimulationAndSaysSo) {
  SidesTruth t;
  t.published_only = true;
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.real.results.push_back(
      {"ball", {{"radius_mm", 19.065}}, {{"center_mm", {6.567, -5.497, 270.634}}}});
  scene.twin.real.results_source = "IEEE Access 2023, Table 5";
  const std::string html = write("published", scene);
  EXPECT_THAT(html, HasSubstr("There are no real images"));
  EXPECT_THAT(html, HasSubstr("IEEE Access 2023, Table 5"));
  EXPECT_THAT(html, Not(HasSubstr("id=\"gain\"")));
  EXPECT_THAT(html, Not(HasSubstr("id=\"budget\"")));
  EXPECT_THAT(html, HasSubstr("id=\"phase\""));
  expect_self_contained(html);
}

TEST(ReportPage, WithoutACauseItShowsWhatTheRestFollows) {
  LeftOver left{"left", 20.0, 15.0, {}};
  for (int i = 0; i < 40 * 30 * 6; ++i)
    left.values.push_back({.sigmas = i % 6 == 4 ? 5.0F : -1.0F,
                           .level_dn = static_cast<float>(i % 97),
                           .phase_rad = static_cast<float>(i % 61),
                           .x_px = static_cast<float>(i / 6 % 40),
                           .y_px = static_cast<float>(i / 240),
                           .image = i % 6});
  const std::string html = write("pattern", testing::make_sides({}), {}, find_pattern({left}, 36000.0));
  EXPECT_THAT(html, HasSubstr("what is left follows the image number (100 % of it: light"));
  EXPECT_THAT(html, HasSubstr("id=\"causes\""));
  EXPECT_THAT(html, HasSubstr("mean of what is left"));
  expect_self_contained(html);
  expect_unique_ids(html);
}

TEST(ReportPage, WithoutLimitsTheBadgeSaysSo) {
  SyntheticSides scene = testing::make_sides({});
  const std::string html = write("no_limits", scene);
  EXPECT_THAT(html, HasSubstr("; no limits set</div>"));
  EXPECT_THAT(html, HasSubstr("<div class=\"verdict none\">"));
  EXPECT_THAT(html, Not(HasSubstr("verdict pass\"")));
  scene.twin.limits = {{"center_mm", 0.1}};
  EXPECT_THAT(write("no_limits", scene), HasSubstr("; limits met</div>"));
}

TEST(ReportPage, HostileNamesStayText) {
  const std::string hostile = "x'\" onload=alert(1) <script>alert(2)</script> `touch pwned`";
  SyntheticSides scene = testing::make_sides({});
  scene.twin.objects[0].name = scene.twin.measure.fits[0].object = hostile;
  scene.twin.cameras[0].name = hostile;
  for (Side* side : {&scene.real, &scene.simulated}) {
    side->measurement->fits[0].object = hostile;
    side->measurement->cameras[0].camera = hostile;
    side->images[0].camera = hostile;
  }
  // a file name cannot hold "</script>": the twin's reader refuses such names, the page must stand them
  const std::string safe = std::regex_replace(hostile, std::regex("/"), "|");
  for (std::string* name :
       {&scene.twin.objects[0].name, &scene.twin.measure.fits[0].object, &scene.twin.cameras[0].name})
    *name = safe;
  for (Side* side : {&scene.real, &scene.simulated}) side->measurement->fits[0].object = safe;
  const std::string html = write("hostile", scene);
  EXPECT_EQ(html.find("<script"), html.rfind("<script"));  // the page's own, at its end
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  std::size_t seen = 0;
  for (std::size_t at = html.find(" onload="); at != std::string::npos;
       at = html.find(" onload=", at + 1), ++seen)
    EXPECT_GT(html.rfind('>', at), html.rfind('<', at)) << "in a tag: " << html.substr(at - 60, 120);
  EXPECT_GT(seen, 3u);
  expect_unique_ids(html);
}

TEST(ReportPage, CloudViewHasALengthScale) {
  const std::string html = write("scale", testing::make_sides({}));
  EXPECT_TRUE(std::regex_search(
      html, std::regex("<div class=\"scale\"><span style=\"width:[0-9.]+%\"></span>[0-9.]+ mm")));
}

TEST(ReportPage, IrradianceAsTheRealSide) {
  SyntheticSides scene = testing::make_sides({});
  for (CameraImages& images : scene.real.images) images.radiance = true;
  const std::string html = write("radiance", scene);
  EXPECT_THAT(html, HasSubstr("id=\"gain\""));
  EXPECT_THAT(html, HasSubstr("in 80 bins, the fitted line"));
}

TEST(ReportPage, FullSizeStaysBelowEightMegabytes) {
  SidesTruth t;
  t.width = 1440;
  t.height = 1080;
  t.cameras = 2;
  t.pitches_px = {15};
  t.noise_dn = 3.0;
  t.albedo_sigma = 0.05;
  t.geometry_rad = 0.05;
  const std::string html = write("large", testing::make_sides(t));
  EXPECT_LT(html.size(), 8u << 20);
  RecordProperty("bytes", static_cast<int>(html.size()));
}

TEST(ReportPage, WithoutGnuplotTheRestIsStillWritten) {
  const SyntheticSides scene = testing::make_sides({});
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nonexistent", 1);
  const std::string html = write("no_gnuplot", scene);
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(html, HasSubstr("gnuplot-nox"));
  EXPECT_THAT(html, HasSubstr("id=\"gain\""));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,"));
}

TEST(ReportPage, WritesTheSameBytesTwice) {
  const SyntheticSides scene = testing::make_sides({});
  const std::string page = write("same", scene);
  EXPECT_EQ(page, write("same", scene));
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const std::string of_one_thread = write("same", scene);
  omp_set_num_threads(threads);
  EXPECT_EQ(page, of_one_thread);
}

}  // namespace
}  // namespace fringetwin::compare::report_page_test
