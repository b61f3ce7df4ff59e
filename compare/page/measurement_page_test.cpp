// SPDX-License-Identifier: Apache-2.0
// The page of a single measurement: what was put in stands on it, counted and named.
// tolerance: none, texts and counts are exact.
#include "compare/page/measurement_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "compare/page/pixel_fates.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::measurement_page_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class MeasurementPage : public ::testing::Test {
 protected:
  void SetUp() override {
    testing::SidesTruth truth;
    truth.cameras = 2;
    sides_ = testing::make_sides(truth);
    sides_.twin.projector =
        Projector{.lens = sides_.twin.cameras[0].lens, .T_proj_world = {}, .response = {}};
    std::filesystem::create_directories(dir_ / "set");
  }
  void TearDown() override { std::filesystem::remove_all(dir_); }
  measure::Measurement& measured() { return *sides_.real.measurement; }
  std::string page() {
    const Provenance provenance{
        {"fringetwin", "measure", "twin.toml", "--out", "my run"}, "0.1.0", {}, "", {}, 1};
    write_measurement_page(dir_, sides_.twin, measured(), dir_ / "set", provenance, {{"measure", 0.8}});
    std::ifstream in(dir_ / "report.html");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  testing::SyntheticSides sides_;
  std::filesystem::path dir_ =
      std::filesystem::temp_directory_path() / ("fringetwin_measured_page_" + std::to_string(::getpid()));
};

TEST_F(MeasurementPage, BeginsWithTheAnswerAndHasEverySectionAndMap) {
  const std::string html = page();
  const measure::ObjectFit& ball = measured().fits.at(0);
  EXPECT_THAT(html, HasSubstr(" points; ball: radius "));
  EXPECT_THAT(html, HasSubstr("rms"));
  for (const char* id : {"fits", "pixels", "phase", "deviation", "timing", "provenance"})
    EXPECT_THAT(html, HasSubstr(std::string("id=\"") + id + "\"")) << id;
  EXPECT_LT(html.find("class=\"answer\""), html.find("What to do next:"));
  EXPECT_THAT(html, HasSubstr("fringetwin measure twin.toml --out &#39;my run&#39;"));
  EXPECT_THAT(html, HasSubstr("ball: signed histogram of the deviation (measured n = "));
  EXPECT_GT(ball.index.size(), 1000U);
  EXPECT_THAT(html, HasSubstr("<p>Pixels that show too little modulation: background"));
  EXPECT_THAT(html, Not(HasSubstr("<p>Pixels that are saturated"))) << "there are none";
  for (const char* file : {"pixels_left.png", "pixels_right.png", "phase_left_x.png",
                           "modulation_right_x.png", "phase_sigma_left_x.png", "deviation_ball_measured.png"})
    EXPECT_TRUE(std::filesystem::exists(dir_ / file)) << file;
}

TEST_F(MeasurementPage, NextCommandDependsOnWhereTheImagesAre) {
  const std::string apart = page();
  EXPECT_THAT(apart, HasSubstr("fringetwin render "));
  EXPECT_THAT(apart, HasSubstr("--real " + (dir_ / "set").string()));
  sides_.twin.real.captures = dir_ / "set";
  const std::string own = page();
  EXPECT_THAT(own, HasSubstr("fringetwin cosim "));
  EXPECT_THAT(own, Not(HasSubstr("fringetwin render ")));
  sides_.twin.projector.reset();
  EXPECT_THAT(page(), HasSubstr("describe projector and part in the twin"));
}

TEST_F(MeasurementPage, WithoutPointsItSaysSo) {
  measured().cloud = {};
  measured().fits.clear();
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("No point was measured."));
  EXPECT_THAT(html, HasSubstr("find out below which pixels were masked"));
  EXPECT_THAT(html, Not(HasSubstr("id=\"fits\"")));
  EXPECT_THAT(html, HasSubstr("id=\"pixels\""));
}

TEST_F(MeasurementPage, AFitThatDidNotComeAboutIsNamed) {
  measured().fits[0].usable = false;
  measured().fits[0].warning = "too <few> points";
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("ball: no fit"));
  EXPECT_THAT(html, HasSubstr("too &lt;few&gt; points"));
  EXPECT_THAT(html, Not(HasSubstr("id=\"deviation\"")));
}

TEST_F(MeasurementPage, EachPixelHasOneFate) {
  measure::Measurement& m = measured();
  ImageU8& flags = m.cameras[0].flags;
  std::ranges::fill(flags.data, measure::kValid);
  const Eigen::Vector2f point = m.cloud.q_cam_px[0];
  flags(0, 0) =
      measure::kLowModulation | measure::kOrderInvalid;  // an order is looked for where there are fringes
  flags(1, 0) = measure::kOrderInvalid;
  flags(2, 0) = measure::kSaturated | measure::kLowModulation;
  const Image<PixelFate> left = pixel_fates(m, 0);
  EXPECT_EQ(left(0, 0), PixelFate::dark);
  EXPECT_EQ(left(1, 0), PixelFate::no_order);
  EXPECT_EQ(left(2, 0), PixelFate::saturated);
  EXPECT_EQ(left(3, 0), PixelFate::decoded);
  EXPECT_EQ(left(static_cast<int>(point.x()), static_cast<int>(point.y())), PixelFate::point);
  m.cameras[1].flags = flags;
  EXPECT_EQ(pixel_fates(m, 1)(static_cast<int>(point.x()), static_cast<int>(point.y())), PixelFate::decoded);
  EXPECT_THAT(fate_reason(PixelFate::dark, sides_.twin, m), HasSubstr("min_modulation_dn = 5 "));
  m.triangulation.n_no_match = 1234;
  EXPECT_THAT(fate_reason(PixelFate::decoded, sides_.twin, m), HasSubstr("234 without a match"));
}

TEST_F(MeasurementPage, ImagesOfRadianceHaveNoLimitInDn) {
  measure::Measurement& m = measured();
  EXPECT_THAT(page(), HasSubstr("modulation [DN]"));
  for (measure::CameraDecode& camera : m.cameras) camera.radiance = true;
  const std::string dark = fate_reason(PixelFate::dark, sides_.twin, m);
  EXPECT_THAT(dark, HasSubstr("0.001 of what the brightest pixels"));
  EXPECT_THAT(dark, Not(HasSubstr("min_modulation_dn =")));
  EXPECT_THAT(dark, Not(HasSubstr("expose longer")));
  EXPECT_THAT(page(), Not(HasSubstr("modulation [DN]"))) << "the modulation's map";
  m.cameras[1].radiance = false;  // sets of both kinds: both limits
  EXPECT_THAT(fate_reason(PixelFate::dark, sides_.twin, m),
              AllOf(HasSubstr("0.001 of what the brightest"), HasSubstr("min_modulation_dn = 5 ")));
}

TEST_F(MeasurementPage, ASetOfCodeAloneHasWordsAndNoPitches) {
  measure::Measurement& m = measured();
  sides_.twin.fringes.steps = 0;
  sides_.twin.fringes.unwrap = Unwrap::gray;
  GrayCode& gray = sides_.twin.fringes.directions.at(0).gray.emplace();
  gray.threshold = GrayCode::Threshold::inverse;
  m.cameras[0].flags(0, 0) = measure::kLowModulation;
  m.cameras[0].flags(1, 0) = measure::kOrderInvalid;
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("<p>Pixels that have no certain word of the code: a bit of the code"));
  EXPECT_THAT(html, HasSubstr("pattern and inverse are not 5 DN apart"));
  EXPECT_THAT(html, HasSubstr("the modulation of the code (half of white minus black"));
  EXPECT_THAT(html, Not(HasSubstr("fringe order")));
  EXPECT_THAT(html, Not(HasSubstr("at some pitch")));
  gray.threshold = GrayCode::Threshold::white_black;
  EXPECT_THAT(fate_reason(PixelFate::no_order, sides_.twin, m), HasSubstr("is not 2.5 DN away from it"));
  for (measure::CameraDecode& camera : m.cameras) camera.radiance = true;
  EXPECT_THAT(fate_reason(PixelFate::no_order, sides_.twin, m), Not(HasSubstr("DN")));
}

TEST_F(MeasurementPage, PixelsWithoutAPointAreExplainedByTheRigThatIsThere) {
  measure::Measurement& m = measured();
  sides_.twin.measure.triangulate = Triangulate::projector;
  EXPECT_THAT(fate_reason(PixelFate::decoded, sides_.twin, m), Not(HasSubstr("the other image")));
  sides_.twin.fringes.unwrap = Unwrap::none;
  EXPECT_EQ(fate_reason(PixelFate::decoded, sides_.twin, m),
            "this rig and these fringes cannot be triangulated");
}

}  // namespace
}  // namespace fringetwin::compare::measurement_page_test
