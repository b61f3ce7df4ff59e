// SPDX-License-Identifier: Apache-2.0
// No tolerances: sentences. The numbers in them differ from each other everywhere, so that an exchange shows.
#include "compare/page/answer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/text.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::answer_test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

ExplainedRow row_of(const std::string& quantity, const std::string& state, double rms = 0.0,
                    double chi2 = 1.0) {
  ExplainedRow row;
  row.quantity = quantity, row.state = state, row.region = "left";
  row.unit = quantity == "gray" ? "DN" : quantity == "phase" ? "rad" : "mm";
  row.observed = rms * rms;
  row.chi2 = chi2, row.chi2_limit = 1.02, row.regional_chi2 = 1.0, row.regional_limit = 1.1;
  return row;
}

Comparison gray_differs() {
  Comparison c;
  c.explained = {row_of("gray", kNotExplained, 1.5, 1.44), row_of("gray", kNotExplained, 4.7, 5.29),
                 row_of("phase", kExplained), row_of("geometry", kExplained)};
  return c;
}

/// `causes`: each an explanation of its own.
Comparison caused_by(std::vector<std::string> causes) {
  Comparison c = gray_differs();
  c.causes.together = std::move(causes);
  for (const char* group : {"blur", "pose", "response"}) {
    CauseRow& row = c.causes.rows.emplace_back();
    row.group = group, row.cause = std::string("the ") + group;
  }
  return c;
}

std::string command(const NextStep& next) { return report::shell_command(next.argv); }

const std::vector<std::string> kCosim{"build/fringetwin", "cosim", "my twin.toml", "--out", "out/a/"};

TEST(Answer, NothingJudgedIsNothingSaid) {
  EXPECT_EQ(answer_sentence({}), "");
  EXPECT_EQ(next_step({}, {}, kCosim).text, "");
}

TEST(Answer, SaysInWhatTheyAgreeAndByHowMuchTheyDiffer) {
  EXPECT_EQ(answer_sentence(gray_differs()),
            "Twin and rig agree in phase and geometry; gray differs by 4.70 DN rms, 2.3 times what noise and "
            "budget allow");
  Comparison c;
  c.explained = {row_of("gray", kExplained), row_of("phase", kExplained), row_of("coverage", kExplained)};
  EXPECT_EQ(answer_sentence(c),
            "Twin and rig agree in coverage, phase and gray, within what noise and budget "
            "allow");
  c.explained = {row_of("phase", kNotExplained, 0.03, 4.0), row_of("gray", kNotCompared)};
  EXPECT_EQ(answer_sentence(c),
            "Twin and rig agree in nothing that was compared: phase differs by 0.0300 rad "
            "rms, 2.0 times what noise and budget allow; gray could not be compared");
}

TEST(Answer, SaysByHowMuchMoreThanAFitToTheValuesLeaves) {
  Comparison c;
  ExplainedRow fitted = row_of("gray", kNotExplained, 1.97, 0.95);
  fitted.chi2_limit = 0.86;
  c.explained = {fitted};
  EXPECT_THAT(answer_sentence(c),
              HasSubstr("gray differs by 1.97 DN rms, 1.05 times what noise and budget allow"));
}

TEST(Answer, SaysWhatIsBeyondALimitThatSingleValuesAreWithin) {
  Comparison c;
  ExplainedRow regions = row_of("gray", kNotExplained, 1.3, 1.01);
  regions.regional_chi2 = 9.0;
  c.explained = {regions};
  EXPECT_THAT(answer_sentence(c),
              HasSubstr("gray differs by 1.30 DN rms, no more than noise in single values, "
                        "but 3.0 times as much in regions"));
  ExplainedRow ripple = row_of("phase", kNotExplained, 0.02);
  ripple.why = "the phase ripples 4 times per fringe; more";
  c.explained = {ripple};
  EXPECT_THAT(answer_sentence(c), HasSubstr("phase differs: the phase ripples 4 times per fringe"));
  ExplainedRow holes = row_of("coverage", kNotExplained);
  holes.why = "1739 pixels (0.8 %) are measured on the real side only, 788 of them away from outlines; more";
  c.explained = {holes};
  EXPECT_EQ(answer_sentence(c),
            "Twin and rig agree in nothing that was compared: coverage differs: 1739 pixels "
            "(0.8 %) are measured on the real side only");
  ExplainedRow ball = row_of("geometry", kNotExplained, 0.0123, 49.0);
  ball.worst = "radius_mm", ball.region = "ball";
  c.explained = {ball};
  EXPECT_THAT(answer_sentence(c), HasSubstr("radius_mm of ball differs by 12.3 µm, 7.0 standard errors"));
  ExplainedRow wide = row_of("gray", kTooWide);
  wide.too_wide_factor = 6.0;
  c.explained = {wide};
  EXPECT_THAT(answer_sentence(c), HasSubstr("the budget of gray is too wide to tell: 6.0 times the noise"));
}

// Of cameras that all fail the one furthest beyond its allowance speaks.
TEST(Answer, OfCoverageTheCameraFurthestOffIsQuoted) {
  Comparison c;
  for (const char* camera : {"left", "right"}) {
    ExplainedRow& row = c.explained.emplace_back(row_of("coverage", kNotExplained));
    row.region = camera, row.why = std::string(camera) + " has holes";
    CoverageRow& counts = c.coverage.emplace_back();
    counts.camera = camera, counts.allowed_thick = 9.0;
    counts.real_only.thick = c.coverage.size() == 1 ? 10 : 700;
  }
  EXPECT_THAT(answer_sentence(c), HasSubstr("coverage differs: right has holes"));
  c.coverage[0].real_only.thick = 701;
  EXPECT_THAT(answer_sentence(c), HasSubstr("coverage differs: left has holes"));
}

TEST(Answer, AnotherSurfaceStandsBeforeWhatAgrees) {
  Comparison c = gray_differs();
  for (const std::uint64_t n : {210u, 2485u, 305u}) {
    OtherSurfaceRow& row = c.other_surfaces.emplace_back();
    row.camera = n == 305 ? "right" : "left", row.n = n;
    row.why = "something stands there: " + std::to_string(n) + " pixels";
    row.place_mm = {0.0, 0.0, 300.0};
  }
  EXPECT_EQ(
      answer_sentence(c),
      "Something stands there: 2485 pixels (camera left) (the largest of 2 such areas); what both show "
      "agrees in phase and geometry; gray differs by 4.70 DN rms, 2.3 times what noise and budget allow");
  EXPECT_THAT(next_step(c, {}, kCosim).text, HasSubstr("put what stands there into the twin"));
  OtherSurfaceRow& largest = c.other_surfaces[1];
  largest.seen = largest.object = "wall";
  EXPECT_THAT(next_step(c, {}, kCosim).text, HasSubstr("check the pose of \"wall\" in the twin"));
  largest.object = "box";
  EXPECT_THAT(next_step(c, {}, kCosim).text, HasSubstr("the twin has \"box\" there and the rig does not"));
  largest.seen.clear(), largest.place_mm.clear();
  EXPECT_THAT(next_step(c, {}, kCosim).text, HasSubstr("which of rig and twin has something there"));
  c.explained = {row_of("gray", kNotExplained, 4.7, 5.29)};
  EXPECT_THAT(answer_sentence(c), HasSubstr("such areas); gray differs by"));
}

TEST(Answer, NamesTheCauseAndTheCommandThatFitsIt) {
  const Comparison one = caused_by({"blur"});
  EXPECT_THAT(answer_sentence(one), HasSubstr("budget allow; most likely cause: the blur"));
  EXPECT_EQ(command(next_step(one, {}, kCosim)),
            "build/fringetwin cosim 'my twin.toml' --out out/a-refined --refine blur");
  const Comparison two = caused_by({"pose + response", "blur"});
  EXPECT_THAT(answer_sentence(two), HasSubstr("most likely cause: the pose and the response or the blur"));
  EXPECT_EQ(command(next_step(two, {}, kCosim)),
            "build/fringetwin cosim 'my twin.toml' --out out/a-refined --refine pose,response");
}

TEST(Answer, RepeatsACommandWithTheProgramsOwnOptions) {
  Twin twin;
  twin.file = "elsewhere/twin.toml";
  EXPECT_EQ(command(next_step(
                caused_by({"blur"}), twin,
                {"fringetwin", "-q", "--limits", "10", "cosim", "t.toml", "--samples", "9", "--out", "o"})),
            "fringetwin -q --limits 10 cosim t.toml --samples 9 --out o-refined --refine blur");
  EXPECT_EQ(
      command(next_step(caused_by({"blur"}), twin, {"fringetwin", "-q", "compare", "cosim", "--out", "o"})),
      "fringetwin cosim elsewhere/twin.toml --out o-refined --refine blur");
}

TEST(Answer, RefinesWhatMovedWhereAllPlacesWouldMoveTogether) {
  Comparison c = caused_by({"rig + pose + response"});
  c.causes.rows.resize(2);
  c.causes.rows[0].group = "rig";
  c.causes.rows[0].parameters = {{"projector.turn_rad.y", "rad", 0.0, 6e-4, 6e-6},
                                 {"projector.shift_mm.x", "mm", 0.0, 0.01, 0.006},
                                 {"right.turn_rad.y", "rad", 0.0, 2e-6, 8e-6}};
  c.causes.rows[1].group = "pose";
  c.causes.rows[1].parameters = {{"ball.center_mm.x", "mm", 0.0, 0.2, 0.002},
                                 {"ball.center_mm.z", "mm", 656.3, 656.31, 0.02},
                                 {"wall.offset_mm", "mm", 0.0, -0.01, 0.02}};
  const std::string all = "build/fringetwin cosim 'my twin.toml' --out out/a-refined --refine ";
  EXPECT_EQ(command(next_step(c, {}, kCosim)),
            all + "projector.turn_rad,projector.shift_mm,ball.center_mm,response");
  c.causes.rows[1].parameters[2] = {"wall.offset_mm", "mm", 0.0, -0.1, 0.02};
  EXPECT_EQ(command(next_step(c, {}, kCosim)),
            all + "projector.turn_rad,projector.shift_mm,ball.center_mm,wall.offset_mm,response");
  // nothing is asked for twice, and what was just fitted is not recommended again
  c.refinement.emplace().asked = {"ball.center_mm", "projector.turn_rad"};
  EXPECT_EQ(command(next_step(c, {}, kCosim)),
            all + "ball.center_mm,projector.turn_rad,projector.shift_mm,wall.offset_mm,response");
  c.refinement->asked = {"projector.turn_rad", "projector.shift_mm", "ball.center_mm", "wall.offset_mm",
                         "response"};
  EXPECT_EQ(command(next_step(c, {}, kCosim)), "");
  c.refinement.reset();
  c.causes.rows.pop_back();  // what of the objects moved is not known
  EXPECT_EQ(command(next_step(c, {}, kCosim)), all + "rig,pose,response");
}

TEST(Answer, ARefinementGoesOnWithWhatItFitted) {
  Comparison c = caused_by({"blur"});
  c.refinement.emplace().asked = {"pose"};
  c.causes.refined = {"pose"};
  Twin twin;
  twin.file = "rig/twin.toml";
  EXPECT_EQ(command(next_step(c, twin, {"fringetwin", "cosim", "t.toml", "--refine=pose", "--out=o"})),
            "fringetwin cosim t.toml --out o-refined --refine pose,blur");
  c.causes.refined = {"pose", "blur"};  // to fit it again would not help
  EXPECT_EQ(command(next_step(c, twin, kCosim)), "");
  EXPECT_EQ(
      command(next_step(caused_by({"blur"}), twin,
                        {"fringetwin", "compare", "x.toml", "--real", "r", "--sim", "s", "--out", "o"})),
      "fringetwin cosim rig/twin.toml --out o-refined --refine blur");
}

TEST(Answer, WithoutACauseTheWarningsComeFirst) {
  Comparison c = gray_differs();
  c.warnings = {"left: another order of the images", "second"};
  EXPECT_EQ(next_step(c, {}, kCosim).text, "read the warnings: left: another order of the images");
}

/// A rig whose images may be refined by anything that belongs to projector and camera.
Twin rig() {
  Twin twin = testing::make_sides({.steps = 8}).twin;
  twin.projector = Projector{.lens = twin.cameras[0].lens, .T_proj_world = Pose{}, .response = {}};
  twin.file = "my twin.toml";
  return twin;
}

// What real rigs show: lamps flicker, projectors bend the waveform, surfaces are no single gray; no one of
// these explains all.
TEST(Answer, WhatTheImagesShowIsFittedTogetherWhereNoCauseExplainsAll) {
  Comparison c = gray_differs();
  c.warnings = {"of exposure"};
  c.explained[2] = row_of("phase", kNotExplained, 0.05, 1.8);
  c.explained[2].brightness_chi2 = 80.0, c.explained[2].harmonic_chi2 = 7.0;
  c.explained[2].ripple_limit = 4.6;
  for (const auto& [group, alone] :
       {std::pair{"blur", 0.4}, {"texture and offset", 0.97}, {"texture", 0.9}}) {
    CauseRow& row = c.causes.rows.emplace_back();
    row.group = group, row.alone = alone, row.chi2_after = 2.0;
  }
  c.gain.emplace_back().camera = "left";
  c.gain[0].gain_dn = 21.0;  // the twin's is 20
  const NextStep next = next_step(c, rig(), kCosim);
  EXPECT_THAT(next.text, HasSubstr("no cause that was tested explains all; the images show light that varies "
                                   "from image to image, fringes of another waveform, a brightness"));
  EXPECT_EQ(
      command(next),
      "build/fringetwin cosim 'my twin.toml' --out out/a-refined --refine light,harmonics,texture,offset");
  c.causes.rows[1].alone = 0.45, c.causes.rows[2].alone = 0.48;  // of each too little
  c.explained[2].harmonic_chi2 = 4.5;
  EXPECT_THAT(next_step(c, rig(), kCosim).text,
              HasSubstr("from image to image: fit it and see what is left"));
  EXPECT_THAT(command(next_step(c, rig(), kCosim)), EndsWith("--refine light"));
  c.causes.rows[2].alone = 0.8;
  c.refinement.emplace().converged = true;
  c.refinement->asked = {"light", "albedo"};  // a texture contains the albedo, and light is fitted
  EXPECT_EQ(next_step(c, rig(), kCosim).text, "read the warnings: of exposure");
  c.refinement->asked = {"light"};
  EXPECT_THAT(command(next_step(c, rig(), kCosim)), EndsWith("--refine light,texture"));
  Twin by_white = rig();
  by_white.fringes.unwrap = Unwrap::gray;
  by_white.fringes.directions[0].gray.emplace().threshold = GrayCode::Threshold::white_black;
  EXPECT_EQ(next_step(c, by_white, kCosim).text, "read the warnings: of exposure");
}

TEST(Answer, WhatTheImagesShowIsNotFittedToWhatWarningsSay) {
  Comparison c;
  c.warnings = {"of exposure"};
  c.explained = {row_of("gray", kExplained), row_of("phase", kNotExplained, 0.02, 1.2)};
  c.explained[1].brightness_chi2 = 80.0, c.explained[1].ripple_limit = 4.6;
  const auto is_light = [&](const Twin& twin = rig()) {
    return next_step(c, twin, kCosim).text ==
           "the images show light that varies from image to image: fit it and see what is left";
  };
  EXPECT_TRUE(is_light());  // no cause is looked for where gray is explained
  c.shows_other_fringes = true;
  EXPECT_FALSE(is_light());
  c.shows_other_fringes = false;
  c.gain.emplace_back().camera = "left";
  c.gain[0].gain_dn = 230.0;  // of 20: a brightness that is not the rig's
  EXPECT_FALSE(is_light());
  c.gain[0].gain_dn = 30.0;
  EXPECT_TRUE(is_light());
  c.refinement.emplace().asked = {"harmonics"};
  EXPECT_FALSE(is_light()) << "a refinement that did not come to rest";
  c.refinement->converged = true;
  EXPECT_TRUE(is_light());
  c.refinement->taken_back = true;
  EXPECT_FALSE(is_light());
  c.refinement->taken_back = false;
  c.refinement->asked = {"exposure"};
  EXPECT_FALSE(is_light()) << "nothing tells them apart";
  c.refinement.reset();
  Twin by_pitch = rig();
  by_pitch.compare.hold_out = 4, by_pitch.compare.hold_out_by = HeldOutBy::pitches;
  EXPECT_FALSE(is_light(by_pitch));
}

// A projector that is brighter than the twin's: the gain takes that up, and weak fringes at outlines are
// measured on one side only.
TEST(Answer, OtherBrightnessIsToldWhereOnlyCoverageIsWrong) {
  Twin twin;
  twin.file = "my twin.toml";
  const Lens lens("LENSMODEL_PINHOLE", {80, 80, 31.5, 23.5}, {64, 48}, "left");
  twin.cameras.push_back({"left", lens, {}, {}, {}});
  twin.cameras[0].sensor.gain_dn = 2.0;
  Comparison c;
  c.explained = {row_of("gray", kExplained), row_of("phase", kExplained), row_of("coverage", kNotExplained)};
  c.warnings = {"of coverage"};
  GainRow& gain = c.gain.emplace_back();
  gain.camera = "left", gain.usable = true, gain.gain_dn = 2.4, gain.gain_sigma_dn = 1e-4;
  CoverageRow& coverage = c.coverage.emplace_back();
  coverage.camera = "left";
  coverage.real_only.n = 900, coverage.real_only.lost_low_modulation = 70,
  coverage.real_only.lost_order = 800;
  const NextStep next = next_step(c, twin, kCosim);
  EXPECT_THAT(next.text, HasSubstr("camera left are 1.2 times as bright as the twin's"));
  EXPECT_THAT(next.text, HasSubstr("gain_dn = 2.4"));
  EXPECT_EQ(command(next), "build/fringetwin cosim 'my twin.toml' --out out/a-refined --refine gain");
  c.refinement.emplace().asked = {"rig"};
  EXPECT_THAT(command(next_step(c, twin, kCosim)), HasSubstr("--refine rig,gain"));
  c.refinement->asked = {"texture"};  // which contains the gain
  EXPECT_THAT(next_step(c, twin, kCosim).text, HasSubstr("read the warnings"));
  c.refinement.reset();
  c.gain[0].gain_dn = 2.02;  // a hundredth, which moves no pixel over the threshold
  EXPECT_THAT(next_step(c, twin, kCosim).text, HasSubstr("read the warnings"));
  c.gain[0].gain_dn = 2.4, c.coverage[0].real_only.lost_order = 40;  // most are in shadow, say
  EXPECT_THAT(next_step(c, twin, kCosim).text, HasSubstr("read the warnings"));
  c.coverage[0].real_only.lost_order = 800,
  c.coverage[0].simulated_only.n = 1000;  // the darker side has more
  EXPECT_THAT(next_step(c, twin, kCosim).text, HasSubstr("read the warnings"));
  c.coverage[0].simulated_only.n = 0;
  c.explained[1].state = kNotExplained;  // more is wrong than brightness
  EXPECT_THAT(next_step(c, twin, kCosim).text, HasSubstr("read the warnings"));
}

TEST(Answer, AnAgreementIsTriedOnImagesThatAreHeldOut) {
  Comparison c;
  c.explained = {row_of("gray", kExplained)};
  Twin twin;
  twin.fringes.steps = 4;
  EXPECT_EQ(next_step(c, twin, kCosim).text, "");  // no captures
  twin.real.captures = "real";
  EXPECT_EQ(command(next_step(c, twin, kCosim)),
            "build/fringetwin cosim 'my twin.toml' --out out/a-held-out --hold-out 4");
  for (const std::vector<std::string>& into :
       {std::vector<std::string>{"--into", "t.toml"}, {"--into=t.toml"}}) {
    std::vector<std::string> argv = {"fringetwin", "cosim", "t.toml"};
    argv.insert(argv.end(), into.begin(), into.end());  // a check leaves the twin as it is
    argv.insert(argv.end(), {"--refine", "pose", "--out", "o"});
    EXPECT_EQ(command(next_step(c, twin, argv)),
              "fringetwin cosim t.toml --refine pose --out o-held-out --hold-out 4");
  }
  twin.fringes.steps = 3;  // a fold leaves two, which give no phase
  EXPECT_EQ(next_step(c, twin, kCosim).text, "");
  c.explained = {row_of("gray", kTooWide)};
  EXPECT_THAT(command(next_step(c, twin, kCosim)), HasSubstr("photometry"));
}

}  // namespace
}  // namespace fringetwin::compare::answer_test
