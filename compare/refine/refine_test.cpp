// SPDX-License-Identifier: Apache-2.0
// A refinement never leaves a twin that fits worse than the one it began with.
#include "compare/refine/refine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/parameters/parameters.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "compare/refine/refine_guard.hpp"
#include "compare/refine/refine_start.hpp"
#include "tests/support/compare/synthetic_sides.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/merge/toml_merge.hpp"

namespace fringetwin::compare::refine_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

Twin ball_at(double x_mm) {
  Twin twin;
  twin.objects = {{"ball", SphereShape{{x_mm, 0, 270}, 19}, {}}};
  return twin;
}

Refined refined_to(double x_mm, double chi2_before, double chi2_after) {
  Refined refined{ball_at(x_mm), {}};
  refined.report.rows = {{"ball.center_mm.x", "mm", 5.0, x_mm, 0.01}};
  refined.report.chi2_before = chi2_before;
  refined.report.chi2_after = chi2_after;
  return refined;
}

double x_mm(const Refined& refined) {
  return std::get<SphereShape>(refined.twin.objects[0].shape).center_mm.x();
}

TEST(RefineGuard, AWorseTwinIsTakenBackAndSaidSo) {
  Refined worse = refined_to(7.0, 1.25, 1.5);
  take_back(worse, ball_at(5.0), what_got_worse({.chi2 = 1.25}, {.chi2 = 1.5}));
  EXPECT_EQ(x_mm(worse), 5.0);
  EXPECT_EQ(worse.report.rows[0].after, 5.0);
  EXPECT_EQ(worse.report.chi2_after, 1.25);
  EXPECT_THAT(worse.report.notes, ElementsAre(HasSubstr("rise from 1.25 to 1.5")));
  EXPECT_THAT(worse.report.warnings, ElementsAre(HasSubstr("is taken back")));
}

// 1000 regions: one standard deviation of their mean square is 0.045. 12 values take 12 squares and, three
// standard deviations more, 27 at most by chance: 0.0134 of each of two kinds.
TEST(RefineGuard, TheLightDecidesWhereMoreOfItIsExplainedThanByChance) {
  const auto standing = [](double level, double contrast) {
    Standing s{.chi2 = 1.0, .chi2_of_place = 1.0, .n = 20'000, .shift = {"shift", 1.0, 1.45, 1000}};
    s.light = {{"level", level, 1.14, 1000}, {"contrast", contrast, 1.14, 1000}};
    return s;
  };
  EXPECT_TRUE(leaves_light_alone(standing(1.05, 1.0)));
  EXPECT_FALSE(leaves_light_alone(standing(1.04, 1.04)));
  Standing fringes_fail = standing(1.05, 1.0);
  fringes_fail.shift.chi2 = 1.5;
  EXPECT_FALSE(leaves_light_alone(fringes_fail));
  EXPECT_TRUE(is_better_lit(standing(1.05, 1.0), standing(1.01, 1.0), 12));
  EXPECT_FALSE(is_better_lit(standing(1.05, 1.0), standing(1.03, 1.0), 12));  // 20 squares
  EXPECT_FALSE(is_better_lit(standing(3.0, 1.0), standing(1.15, 1.0), 12));   // a lamp that the twin has not
  Standing moved = standing(1.01, 1.0);
  moved.chi2_of_place = 1.02;
  EXPECT_FALSE(is_better_lit(standing(1.05, 1.0), moved, 12));  // where the fringes say no
}

TEST(RefineGuard, WhatIsNoWorseThanByChanceStays) {
  // 20,000 values: one standard deviation of their mean square is 0.01; of 200 regions two are 0.2
  const Standing before{.chi2 = 1.0, .chi2_of_place = 1.0, .n = 20'000, .shift = {"shift", 1.0, 1.45, 200}};
  Standing after = before;
  after.chi2 = after.chi2_of_place = 1.009;
  after.shift.chi2 = 1.19;
  EXPECT_EQ(what_got_worse(before, after), "");
  after.chi2 = 1.011;
  EXPECT_THAT(what_got_worse(before, after), StartsWith("chi2 would rise from 1 to 1.011"));
  after = before;
  after.chi2_of_place = 1.011;
  EXPECT_THAT(what_got_worse(before, after), HasSubstr("places"));
  after = before;
  after.shift.chi2 = 1.21;
  EXPECT_THAT(what_got_worse(before, after), HasSubstr("shift in regions"));
  Standing quiet = before;  // less than the noise: a rise to what the noise explains is none
  quiet.shift.chi2 = 0.8;
  quiet.scatters = true;
  EXPECT_THAT(what_got_worse(quiet, after), HasSubstr("shift in regions"));
  after.shift.chi2 = 1.19;
  EXPECT_EQ(what_got_worse(quiet, after), "");
  quiet.scatters = false;
  EXPECT_THAT(what_got_worse(quiet, after), HasSubstr("shift in regions"));
}

ExplainedRow row(const std::string& quantity, const char* state, double chi2) {
  ExplainedRow r;
  r.quantity = quantity;
  r.region = "ball";
  r.state = state;
  r.chi2 = chi2;
  return r;
}

TEST(RefineGuard, FitsAndCoverageMustNotGetWorse) {
  const Standing right{.rows = {row("geometry", kExplained, 4.0), row("coverage", kExplained, 0.0)}};
  EXPECT_EQ(what_got_worse(right, right), "");
  EXPECT_THAT(what_got_worse(right, {.rows = {row("geometry", kNotExplained, 16.0)}}),
              HasSubstr("|z| of ball would rise from 2 to 4"));
  EXPECT_THAT(what_got_worse(right, {.rows = {row("coverage", kNotExplained, 0.0)}}), HasSubstr("coverage"));
  EXPECT_THAT(what_got_worse(right, {.rows = {row("geometry", kNotCompared, kNaN)}}),
              HasSubstr("ball could not be compared any more"));
  EXPECT_THAT(what_got_worse({.rows = {}}, {.rows = {row("coverage", kNotCompared, kNaN)}}),
              HasSubstr("not be seen any more"));
  const Standing wrong{.rows = {row("geometry", kNotExplained, 100.0)}};
  EXPECT_EQ(what_got_worse(wrong, {.rows = {row("geometry", kNotExplained, 81.0)}}), "");
}

TEST(RefineGuard, LightInRegionsMustNotPassItsLimit) {
  const CauseRegion within{"level", 1.1, 1.2, 500}, beyond{"level", 1.5, 1.2, 500},
      worse{"level", 9.0, 1.2, 500};
  EXPECT_EQ(what_got_worse({.light = {within}}, {.light = {within}}), "");
  EXPECT_THAT(what_got_worse({.light = {within}}, {.light = {beyond}}), HasSubstr("level in regions"));
  EXPECT_EQ(what_got_worse({.light = {beyond}}, {.light = {worse}}),
            "");  // a place takes no light into account
  EXPECT_THAT(what_got_worse({.light = {beyond}, .fits_light = true}, {.light = {worse}, .fits_light = true}),
              HasSubstr("level in regions"));
  EXPECT_EQ(what_got_worse({.light = {worse}, .fits_light = true}, {.light = {beyond}, .fits_light = true}),
            "");
}

TEST(RefineGuard, ThePhaseMustNotGetWorse) {
  const Standing right{.rows = {row("phase", kExplained, 1.0)}};
  EXPECT_THAT(what_got_worse(right, {.rows = {row("phase", kNotExplained, 1.0)}}),
              HasSubstr("the phase of ball"));
  EXPECT_EQ(what_got_worse(right, {.rows = {row("phase", kTooWide, 0.5)}}), "");
  EXPECT_EQ(what_got_worse({.rows = {row("phase", kNotExplained, 4.0)}},
                           {.rows = {row("phase", kNotExplained, 3.0)}}),
            "");
}

TEST(RefineGuard, AFailingPhaseMustNotFailByMore) {
  const auto failing = [](double chi2, double regional_chi2) {
    ExplainedRow r = row("phase", kNotExplained, chi2);
    r.chi2_limit = 1.1, r.n = 10000, r.regional_chi2 = regional_chi2, r.regional_limit = 1.5,
    r.n_regions = 100;
    return Standing{.rows = {r}};
  };
  // 2 % and two roots of 2/n are 4.9 % of single values and 30.8 % of regions
  EXPECT_EQ(what_got_worse(failing(1.53, 2.0), failing(1.60, 2.6)), "");
  EXPECT_THAT(what_got_worse(failing(1.53, 2.0), failing(1.64, 2.0)),
              StartsWith("chi2 of the phase of ball"));
  EXPECT_THAT(what_got_worse(failing(1.53, 2.0), failing(1.53, 2.7)), HasSubstr("phase of ball in regions"));
  EXPECT_EQ(what_got_worse(failing(1.53, 0.5), failing(1.53, 1.4)), "") << "within its limit";
  EXPECT_THAT(what_got_worse(failing(1.53, 2.0), {.rows = {row("phase", kNotCompared, kNaN)}}),
              HasSubstr("the phase of ball could not be compared"));
  EXPECT_THAT(what_got_worse(failing(1.53, 2.0), {}), HasSubstr("the phase of ball could not be compared"));
}

TEST(RefineGuard, FitsThatStillDifferAreAWarning) {
  Refinement pose;
  pose.asked = {"pose"};
  EXPECT_EQ(
      warning_of_what_is_left(pose, {row("geometry", kExplained, 4.0), row("phase", kNotExplained, 4.0)}),
      "");
  EXPECT_THAT(warning_of_what_is_left(pose, {row("geometry", kNotExplained, 49.0)}),
              AllOf(StartsWith("--refine pose"), HasSubstr("ball by 7 standard errors"),
                    HasSubstr("not to be trusted")));
}

TEST(Refine, WhatNoKeyHoldsIsRefusedWithWhatToDo) {
  Twin twin = ball_at(5.0);
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  twin.cameras.push_back({"left", lens, Pose{}, Sensor{}, std::nullopt});
  twin.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  twin.fringes.directions = {{Axis::x, {13, 14, 15}, {0, 0, 0}, {}}};
  const auto message = [&](const std::string& asked) -> std::string {
    try {
      check_refine(twin, {asked});
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  for (const ParameterGroup& group : parameter_groups())
    if (!group.instead.empty()) {
      EXPECT_THAT(message(group.name), ::testing::HasSubstr(group.instead));
      EXPECT_THAT(refine_names(), ::testing::Not(::testing::HasSubstr(group.name)));
    }
  EXPECT_THAT(message("left.room_light.x"), ::testing::HasSubstr("in the dark"));
  EXPECT_EQ(message("camera_response"), "");
  EXPECT_THAT(message("left.response"), HasSubstr("camera_knee and camera_response are both"));
  for (const char* asked :
       {"light", "image_3.light", "size", "intrinsics", "specular", "left", "ball", "projector"})
    EXPECT_EQ(message(asked), "") << asked;
  EXPECT_THAT(message("texture_spread"), HasSubstr("add texture"));
  EXPECT_THAT(message("posee"), HasSubstr("is not known; did you mean \"pose\"? `fringetwin help cosim`"));
  EXPECT_THAT(message("texure"), HasSubstr("did you mean \"texture\"?"));
  EXPECT_LT(message("of none of them").size(), kLongestSentence) << "none of it is left out";
  twin.projector->blur_px = 1.0;  // then it may vary, and that only by its own name
  for (const Parameter& p : refinable_parameters(twin, {"projector"})) EXPECT_NE(p.group, "blur_field");
  EXPECT_EQ(refinable_parameters(twin, {"blur_field"}).size(), 5u);
  twin.fringes.steps = 6;  // orders 2 to 4, both parts, five terms each, by their own name alone
  for (const Parameter& p : refinable_parameters(twin, {"projector"})) EXPECT_NE(p.group, "harmonics_field");
  EXPECT_EQ(refinable_parameters(twin, {"harmonics_field"}).size(), 30u);
  EXPECT_EQ(refinable_parameters(twin, {"projector.harmonics_field.1_0"}).size(), 6u);
  EXPECT_THAT(message("harmonics_high"), HasSubstr("has no such parameter"));
  twin.fringes.steps = 9;  // orders 8 to 16, both parts
  for (const Parameter& p : refinable_parameters(twin, {"projector"})) EXPECT_NE(p.group, "harmonics_high");
  EXPECT_EQ(refinable_parameters(twin, {"harmonics_high"}).size(), 18u);
  twin.render.bounces = 1;
  EXPECT_THAT(message("harmonics_field"), HasSubstr("has no such parameter"));
}

std::vector<std::string> names_asked_by(const Twin& twin, const std::string& word) {
  std::vector<std::string> names;
  for (const Parameter& p : refinable_parameters(twin, {word})) names.push_back(p.name);
  return names;
}

// The name of where an object is is the beginning of that of its motion.
TEST(Refine, AWholeNameAsksForNothingElse) {
  const Twin twin = ball_at(1.0);
  EXPECT_THAT(names_asked_by(twin, "ball.center_mm.x"), ::testing::ElementsAre("ball.center_mm.x"));
  EXPECT_THAT(names_asked_by(twin, "ball.center_mm"), ::testing::SizeIs(3));
  EXPECT_THAT(names_asked_by(twin, "ball.center_mm.x.motion"),
              ::testing::ElementsAre("ball.center_mm.x.motion"));
}

TEST(Refine, VignettingHasTheTermsThatTheTwinStates) {
  Twin twin = fringetwin::testing::make_sides({}).twin;
  const std::string camera = twin.cameras[0].name + ".vignetting";
  const std::vector<std::string> tilt_and_r2{camera + "_tilt.x", camera + "_tilt.y", camera + ".a1"};
  EXPECT_EQ(names_asked_by(twin, "vignetting"), tilt_and_r2);
  EXPECT_THAT(names_asked_by(twin, camera + ".a3"), ::testing::ElementsAre(camera + ".a3"));
  twin.cameras[0].vignetting = {Vignetting::Kind::polynomial, {-0.08, -0.03, 0.0}, {0.0, 0.0}};
  std::vector<std::string> with_r4 = tilt_and_r2;
  with_r4.push_back(camera + ".a2");
  EXPECT_EQ(names_asked_by(twin, "vignetting"), with_r4);
  EXPECT_EQ(parameters_of(twin, "vignetting").size(), 3u);  // the search for causes
  const Parameter r4 = refinable_parameters(twin, {camera + ".a2"}).at(0);
  EXPECT_EQ(r4.start, -0.03);
  r4.change(twin, 0.01);
  EXPECT_NEAR(twin.cameras[0].vignetting.a[1], -0.02, 1e-15);  // a sum of two numbers
}

// A normal is made one of unit length again by every refinement: its last bit is no value that was refined.
TEST(Refine, WhatOnlyRoundingMovedIsNotWritten) {
  Twin before = ball_at(5.0);
  Object wall = before.objects[0];
  wall.name = "wall";
  PlaneShape plane;
  plane.point_mm = {0, 0, 400};
  plane.normal = Eigen::Vector3d(0.06, -0.04, -1.0).normalized();
  wall.shape = plane;
  before.objects.push_back(wall);
  Twin after = before;
  PlaneShape& moved = std::get<PlaneShape>(after.objects[1].shape);
  for (double& part : moved.normal) part = std::nextafter(part, 2.0);
  EXPECT_THAT(refined_toml({}, before, after), ::testing::Not(::testing::HasSubstr("wall")));
  moved.normal.x() += 1e-12;
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[[object]]  # \"wall\"\nnormal = [0.0598"));
}

TEST(Refine, ExposuresAreWrittenAsTheyAreRead) {
  Twin before = ball_at(5.0);
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  before.cameras = {{"left", lens, Pose{}, Sensor{}, std::nullopt}};
  before.fringes.directions = {{Axis::x, {13}, {0}, {}}};
  before.fringes.unwrap = Unwrap::none;
  const std::vector<Parameter> exposure = parameters_of(before, "exposure");
  ASSERT_EQ(exposure.size(), 3u);
  EXPECT_EQ(exposure[0].name, "left.image_1.exposure");
  const Twin after = with_values(before, exposure, Eigen::Vector3d(std::log(1.02), std::log(0.98), 0.0));
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[[camera]]  # \"left\"\nexposure_factors = [1.0004001600640255, 1.02, "
                                   "0.98, 1]\n"));
}

TEST(Refine, LightOfImagesIsWrittenAsItIsRead) {
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  Twin before = ball_at(5.0);
  before.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  before.fringes.directions = {{Axis::x, {13}, {0}, {}}};
  before.fringes.unwrap = Unwrap::none;
  std::vector<Parameter> light = parameters_of(before, "light");
  ASSERT_EQ(light.size(), 3u);
  const Twin after = with_values(before, light, Eigen::Vector3d(std::log(1.02), std::log(0.98), 0.0));
  const std::vector<double>& factors = after.projector->light_factors;
  EXPECT_NEAR(factors[0], 1.0 / (1.02 * 0.98), 1e-15);  // the geometric mean stays 1
  EXPECT_NEAR(factors[1], 1.02, 1e-15);
  EXPECT_EQ(factors[3], 1.0);
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[projector]\nlight_factors = [1.0004001600640255, 1.02, 0.98, 1]\n"));
  // a twin that has factors: the values go on from there
  light = parameters_of(after, "light");
  EXPECT_NEAR(light[0].start, std::log(1.02), 1e-15);
  const Twin back = with_values(after, light, Eigen::Vector3d::Zero());
  for (const double factor : back.projector->light_factors) EXPECT_NEAR(factor, 1.0, 1e-15);
  // steps that are not compared keep theirs
  light = parameters_of(before, "light", {1, 3});
  ASSERT_EQ(light.size(), 1u);
  EXPECT_EQ(light[0].name, "image_3.light");
  const Twin odd = with_values(before, light, Eigen::VectorXd::Constant(1, std::log(1.1)));
  EXPECT_EQ(odd.projector->light_factors[0], 1.0);
  EXPECT_NEAR(odd.projector->light_factors[1], 1.0 / 1.1, 1e-15);
}

TEST(Refine, ShiftsOfImagesAreWrittenAsTheyAreRead) {
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  Twin before = ball_at(5.0);
  before.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  before.projector->image_shifts_px = {0.0, 0.25, 0.0, 0.0};
  before.fringes.directions = {{Axis::x, {13}, {0}, {}}};
  before.fringes.unwrap = Unwrap::none;
  const std::vector<Parameter> shifts = parameters_of(before, "image_shift");
  ASSERT_EQ(shifts.size(), 4u);
  EXPECT_EQ(shifts[1].start, 0.25);
  const Twin after = with_values(before, shifts, Eigen::Vector4d(0.5, 0.25, -0.125, 0.0));
  EXPECT_EQ(after.projector->image_shifts_px, (std::vector<double>{0.5, 0.25, -0.125, 0.0}));
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[projector]\nimage_shifts_px = [0.5, 0.25, -0.125, 0]\n"));
  // steps that are not compared tell nothing of theirs
  EXPECT_EQ(parameters_of(before, "image_shift", {1, 3}).size(), 2u);
  // a raster of pixels stays where it is: no key holds what moves without it
  before.projector->pixel_structure = true;
  EXPECT_FALSE(parameters_of(before, "image_shift").front().change);
  EXPECT_THROW(check_refine(before, {"image_shift"}), UserError);
}

// Of a plane under four pitches of 12 steps the twelfth order took 2 % of what was predicted wrongly.
TEST(Refine, TheOrderOfTheStepsIsAnOffsetOfOnePitchAlone) {
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  Twin twin = ball_at(5.0);
  twin.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  twin.fringes.steps = 9;
  for (const std::vector<double>& pitches : {std::vector<double>{13.0}, {13.0, 14.0}}) {
    twin.fringes.directions = {{Axis::x, pitches, std::vector<double>(pitches.size(), 0.0), {}}};
    const std::vector<Parameter> all = parameters_of(twin, "harmonics_high");
    const std::vector<std::size_t> same = alike_in_all_images(twin, all);
    ASSERT_EQ(same.size(), pitches.size() == 1 ? 2u : 0u);
    for (const std::size_t k : same) EXPECT_EQ(all[k].harmonic, 9);
  }
}

TEST(Refine, WaveformsOfImagesAreWrittenAsTheyAreRead) {
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  Twin before = ball_at(5.0);
  before.projector = Projector{.lens = lens, .T_proj_world = Pose{}, .response = {}};
  before.fringes.directions = {{Axis::x, {13}, {0}, {}}};
  before.fringes.unwrap = Unwrap::none;
  before.fringes.steps = 6;
  const std::vector<Parameter> all = parameters_of(before, "image_harmonics", {1, 4});
  ASSERT_EQ(all.size(), 14u);  // orders 1 to 4: a shift is none
  EXPECT_EQ(all[7].name, "image_4.harmonic.1");
  EXPECT_EQ(all[9].name, "image_4.harmonic.2.quadrature");
  Eigen::VectorXd values = start_values(all);
  values[0] = 0.0625, values[9] = 0.25;
  const Twin after = with_values(before, all, values);
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr(
                  "[fringes]\nimage_harmonics = [[], [[0.0625, 0]], [], [], [[0, 0], [0, 0.25]], []]\n"));
  const std::vector<Parameter> again = parameters_of(after, "image_harmonics", {1, 4});
  EXPECT_EQ(again[0].start, 0.0625);
  EXPECT_EQ(again[9].start, 0.25);
  before.fringes.steps = 5;
  EXPECT_TRUE(parameters_of(before, "image_harmonics").empty());
}

TEST(Refine, SizeAndGlossAreWrittenWhereTheTwinHasThem) {
  const Twin before = ball_at(5.0);
  Twin after = before;
  std::get<SphereShape>(after.objects[0].shape).radius_mm = 19.5;
  after.objects[0].material.specular = 0.25;
  const std::string text = refined_toml({}, before, after);
  EXPECT_THAT(text, ::testing::HasSubstr("[[object]]  # \"ball\"\nradius_mm = 19.5\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("[object.material]  # \"ball\"\nspecular = 0.25\n"));
}

// Every key is the one that changed, with its value afterwards, in the table of its own device or object.
TEST(Refine, EveryKeyIsWrittenUnderItsTable) {
  Twin before = ball_at(5.0);
  const auto lens = [](double f_px) {
    return Lens("LENSMODEL_PINHOLE", {f_px, f_px + 5.0, 31.5, 23.5}, {64, 48}, "test");
  };
  for (const char* name : {"left", "right"})
    before.cameras.push_back({name, lens(900.0), Pose{}, Sensor{}, std::nullopt});
  before.projector = Projector{.lens = lens(700.0), .T_proj_world = Pose{}, .response = {}};
  Twin after = before;
  Camera& right = after.cameras[1];
  right.lens = lens(901.0);
  right.T_cam_world.translation_mm = {1.0, 2.0, 3.0};
  right.vignetting.a = {0.5, 0.25, 0.125};
  right.vignetting.tilt = {0.0625, 0.75};
  right.sensor.gain_dn = 17.5;
  right.sensor.black_level_dn = 4.5;
  after.projector->lens = lens(702.0);
  after.projector->T_proj_world.translation_mm = {4.0, 5.0, 6.0};
  after.projector->intensity = 30.5;
  after.projector->blur_px = 1.5;
  after.projector->response = {ProjectorResponse::Kind::gamma, 2.25, {}};
  after.projector->halo = {{.share = 0.125, .sigma_px = 2.5}, {.share = 0.0625, .sigma_px = 40.0}};
  after.projector->light_field = {0.125, -0.25};
  before.room.lamp_world = {0.5, 0.25, -1.0};
  after.room.lamp_world = {0.5, 0.375, -1.0};
  std::get<SphereShape>(after.objects[0].shape).center_mm = {7.0, 8.0, 271.0};
  after.objects[0].material.diffuse = 0.625;
  after.objects[0].material.mean_free_path_mm = 0.75;
  after.render.bounces = 1;
  const std::string text = refined_toml({}, before, after);
  EXPECT_EQ(
      text.substr(std::min(text.size(), text.find("\n\n") + 2)),
      "[[camera]]  # \"right\"\nintrinsics = [901, 906, 31.5, 23.5]\nrt_cam_world = [0, 0, 0, 1, 2, 3]\n"
      "vignetting = [0.5, 0.25, 0.125]\nvignetting_tilt = [0.0625, 0.75]\n\n"
      "[camera.sensor]  # \"right\"\ngain_dn = 17.5\nblack_level_dn = 4.5\n\n"
      "[projector]\nintrinsics = [702, 707, 31.5, 23.5]\nrt_cam_world = [0, 0, 0, 4, 5, 6]\n"
      "intensity = 30.5\nblur_px = 1.5\nhalo = [[0.125, 2.5], [0.0625, 40]]\nresponse = { gamma = 2.25 "
      "}\nlight_field = "
      "[0.125, -0.25]\n\n"
      "[[object]]  # \"ball\"\ncenter_mm = [7, 8, 271]\n\n"
      "[object.material]  # \"ball\"\ndiffuse = 0.625\nmean_free_path_mm = 0.75\n\n"
      "[room]\nlamp = [0.5, 0.375, -1]\n\n[render]\nbounces = 1\n\n");
}

// A twin whose lenses come from files gets all of a lens of its own, once a number of it is.
TEST(Refine, ALensOfAFileIsMergedWhole) {
  Twin before = ball_at(5.0);
  const auto lens = [](double f_px) {
    return Lens("LENSMODEL_PINHOLE", {f_px, f_px, 31.5, 23.5}, {64, 48}, "test");
  };
  before.cameras = {{"left", lens(900.0), Pose{}, Sensor{}, std::nullopt}};
  before.projector = Projector{.lens = lens(700.0), .T_proj_world = Pose{}, .response = {}};
  Twin after = before;
  after.cameras[0].lens = lens(901.0);
  after.projector->T_proj_world.translation_mm = {4.0, 5.0, 6.0};
  after.render.bounces = 1;
  const std::string text =
      "[[camera]]\nname = \"left\"\nmodel = \"left.cameramodel\"\n[projector]\nposition_mm = [0, 0, 0]\n"
      "look_at_mm = [0, 0, 1]\nlensmodel = \"LENSMODEL_PINHOLE\"\n[[object]]\nname = \"ball\"\n";
  EXPECT_EQ(
      merge_toml(text, refined_blocks(before, after), "twin.toml"),
      "[[camera]]\nname = \"left\"\n# model = \"left.cameramodel\"\nintrinsics = [901, 901, 31.5, 23.5]\n"
      "lensmodel = \"LENSMODEL_PINHOLE\"\nimagersize = [64, 48]\nrt_cam_world = [0, 0, 0, 0, 0, 0]\n"
      "[projector]\n# position_mm = [0, 0, 0]\n# look_at_mm = [0, 0, 1]\nlensmodel = "
      "\"LENSMODEL_PINHOLE\"\nrt_cam_world = [0, 0, 0, 4, 5, 6]\n[[object]]\nname = \"ball\"\n"
      "\n[render]\nbounces = 1\n");
  EXPECT_EQ(merge_toml(text, refinable_tables(after), "twin.toml"), text);
  EXPECT_TRUE(refined_blocks(after, after).empty());
}

TEST(Refine, ALensOfAColourSensorIsWrittenForTheWholeSensor) {
  const auto twin_with = [](double f_px) {
    Twin twin = ball_at(5.0);
    const Lens sensor("LENSMODEL_PINHOLE", {f_px, 905, 31.5, 23.5}, {64, 48}, "test");
    const MosaicChannel blue{"RGGB", MosaicColour::blue, {64, 48}};
    twin.cameras = {{"left", image_lens(sensor, blue, "test"), Pose{}, Sensor{}, std::nullopt}};
    twin.cameras[0].channel = blue;
    return twin;
  };
  EXPECT_THAT(refined_toml({}, twin_with(900.0), twin_with(900.5)),
              HasSubstr("[[camera]]  # \"left\"\nintrinsics = [900.5, 905, 31.5, 23.5]\n"));
}

TEST(Refine, HarmonicsAreWrittenAsTheTwinHasThem) {
  Twin before = ball_at(5.0);
  before.fringes.directions = {{Axis::x, {13, 14}, {0, 0}, {}}};
  Twin after = before;
  after.fringes.directions[0].harmonics.assign(2, {{0.0125, -0.5}, {0.0, 0.25}});
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[fringes.x]\nharmonics = [[0.0125, -0.5], [0, 0.25]]\n"));
  EXPECT_THAT(refined_toml({}, after, after), ::testing::Not(::testing::HasSubstr("harmonics")));
  after.fringes.directions[0].harmonics[1] = {};
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[fringes.x]\nharmonics = [[[0.0125, -0.5], [0, 0.25]], []]\n"));
  before.fringes.directions.push_back({Axis::y, {13}, {0}, {}, {{{0.5, 0.0}}}});
  after.fringes.directions.push_back({Axis::y, {13}, {0}, {}, {{{0.5, 0.125}}}});
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[fringes.y]\nharmonics = [[0.5, 0.125]]\n"));
  after.fringes.directions[0].contrast = {1.0, 0.9375};
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("[0, 0.25]], []]\ncontrast = [1, 0.9375]\n"));
  after.fringes.directions[0].raster = {1.0625, 41, {{0.125, 0.0}, {0.0, -0.25}}};
  EXPECT_THAT(
      refined_toml({}, before, after),
      ::testing::HasSubstr("raster = { pitch_px = 1.0625, first = 41, waves = [[0.125, 0], [0, -0.25]] }\n"));
  after.fringes.directions[0].harmonics_field = {{{0.125, 0.0}, {0.0, -0.25}}, {{0.0, 0.5}}, {}, {}, {}};
  EXPECT_THAT(refined_toml({}, before, after),
              ::testing::HasSubstr("harmonics_field = [[[0.125, 0], [0, -0.25]], [[0, 0.5]], [], [], []]\n"));
}

}  // namespace
}  // namespace fringetwin::compare::refine_test
