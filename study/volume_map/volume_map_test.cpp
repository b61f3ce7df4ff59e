// SPDX-License-Identifier: Apache-2.0
// tolerance: 1e-12 (mm) for sums of few numbers.
#include "study/volume_map/volume_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "study/study_file.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::volume_map_test {
namespace {
using namespace fringetwin::study;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class VolumeMapTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_file(folder_ / "twin.toml", small_twin());
    plan_.twin = folder_ / "twin.toml";
    plan_.object = "ball";
    plan_.radius_mm = 19.0;
    plan_.center_mm = {0, 0, 270};
    plan_.size_mm = {60, 0, 20};
    plan_.counts = {3, 1, 2};
    plan_.trials = 2;
  }
  std::filesystem::path folder_ = scratch_folder("volume_map");
  VolumeMapPlan plan_;
};

TEST_F(VolumeMapTest, LatticeFillsTheVolume) {
  EXPECT_THAT(plan_.positions(),
              ElementsAre(Vector3d(-30, 0, 260), Vector3d(0, 0, 260), Vector3d(30, 0, 260),
                          Vector3d(-30, 0, 280), Vector3d(0, 0, 280), Vector3d(30, 0, 280)));
}

TEST_F(VolumeMapTest, ATrialsRigIsCommonToItsPositionsItsNoiseIsNot) {
  plan_.inputs.keys.push_back({"depth", {"object.ball.center_mm[2]"}, {270.0}, Distribution::normal, 0.5});
  plan_.inputs.keys.push_back({"light", {"projector.intensity"}, {40.0}, Distribution::normal, 1.0});
  plan_.inputs.calibration = 2;
  const auto points = volume_map_points(plan_);
  ASSERT_EQ(points.size(), 12u);
  std::set<std::uint64_t> seeds;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Settings& s = points[i].settings;
    EXPECT_EQ(points[i].id, static_cast<std::int64_t>(i));
    seeds.insert(points[i].seed);
    const Settings& first = points[i / 6 * 6].settings;
    for (const char* key : {"projector.intensity", "uncertainty.calibration.deviates"})
      EXPECT_EQ(s.at(key), first.at(key));
    // The depth is off from where the ball is put: by the same at all positions.
    EXPECT_NEAR(std::stod(s.at("object.ball.center_mm[2]")) - plan_.positions()[i % 6].z(),
                std::stod(first.at("object.ball.center_mm[2]")) - 260.0, 1e-12);
  }
  EXPECT_EQ(seeds.size(), 12u);
  EXPECT_NE(points[0].settings.at("projector.intensity"), points[6].settings.at("projector.intensity"));
  EXPECT_EQ(points[6].seed, draw_inputs(plan_.inputs, 1, DrawStream::trials, 1).noise_seed);

  VirtualRig rig(plan_.twin, false);
  Settings settings = points[5].settings;
  const double depth = std::stod(settings.at("object.ball.center_mm[2]"));
  settings.erase("uncertainty.calibration.deviates");
  const auto center = [](const Twin& twin) { return std::get<SphereShape>(twin.objects[0].shape).center_mm; };
  EXPECT_EQ(center(rig.measuring(settings)), Vector3d(30, 0, 280));
  EXPECT_EQ(rig.measuring(settings).projector->intensity, 40.0);
  EXPECT_EQ(center(rig.drawn(settings)), Vector3d(30, 0, depth));
  EXPECT_NE(rig.drawn(settings).projector->intensity, 40.0);

  plan_.inputs.noise = false;
  EXPECT_EQ(volume_map_points(plan_)[7].seed, 0u);
}

PointOutcome outcome(std::int64_t id, const Vector3d& center, double radius, double form) {
  PointOutcome o;
  o.id = id;
  o.numbers = {{"x_mm", center.x()},  {"y_mm", center.y()}, {"z_mm", center.z()},
               {"radius_mm", radius}, {"form_mm", form},    {"form_95_mm", 0.5 * form}};
  return o;
}

TEST_F(VolumeMapTest, ErrorsOfPlaceSizeFormAndSpacing) {
  plan_.counts = {3, 1, 1};
  plan_.size_mm = {60, 0, 0};
  std::vector<PointOutcome> outcomes;
  // Scales of 1.001 and 1.003 about the world's origin, the second with the last ball higher.
  for (int t = 0; t < 2; ++t)
    for (int p = 0; p < 3; ++p)
      outcomes.push_back(outcome(3 * t + p,
                                 (t == 0 ? 1.001 : 1.003) * plan_.positions()[static_cast<std::size_t>(p)],
                                 t == 0 ? 19.01 : 19.03, 0.02 * (p + 1)));
  const VolumeMap map = volume_map(plan_, outcomes);
  ASSERT_EQ(map.positions.size(), 3u);
  EXPECT_EQ(map.measured, 3u);
  const auto& last = map.positions[2].numbers;
  EXPECT_NEAR(last.at("x_mm").mean, 0.06, 1e-12);
  EXPECT_NEAR(last.at("x_mm").sigma, 0.06 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(last.at("z_mm").mean, 0.54, 1e-12);
  EXPECT_NEAR(last.at("size_mm").mean, 0.04, 1e-12) << "of the diameter";
  EXPECT_NEAR(last.at("form_mm").mean, 0.06, 1e-12);
  EXPECT_NEAR(last.at("form_95_mm").mean, 0.03, 1e-12);
  ASSERT_EQ(map.spacings.size(), 3u);
  EXPECT_EQ(map.spacings[1].a, 0u);
  EXPECT_EQ(map.spacings[1].b, 2u);
  EXPECT_EQ(map.spacings[1].length_mm, 60.0);
  EXPECT_NEAR(map.spacings[1].error_mm.mean, 0.12, 1e-12);
  EXPECT_NEAR(map.spacings[1].error_mm.interval.low, 0.06, 1e-12);
  EXPECT_NEAR(map.spacings[1].error_mm.interval.high, 0.18, 1e-12);
  ASSERT_TRUE(map.worst_spacing);
  EXPECT_EQ(map.worst_spacing->mean, 1u);
  EXPECT_NEAR(map.largest_mm.mean, 0.12, 1e-12);
  EXPECT_EQ(map.worst.at("form_mm").mean, 2u);
  EXPECT_EQ(map.worst.at("x_mm").mean, 0u) << "of equal amounts the first";

  const auto json = nlohmann::json::parse(volume_map_json(plan_, map));
  EXPECT_EQ(json["schema"], "fringetwin-volume-map/1");
  EXPECT_NEAR(json["positions"][2]["z_mm"]["mean"].get<double>(), 0.54, 1e-12);
  EXPECT_NEAR(json["spacing"]["pairs"][1]["error_mm"]["mean"].get<double>(), 0.12, 1e-12);
  EXPECT_EQ(json["spacing"]["worst_mean"], 1);
}

// Scales of 0.999 and 0.997: 60 mm are short by 0.06 and 0.18 mm.
TEST_F(VolumeMapTest, TheLargestErrorOfASpacingHasNoSign) {
  plan_.counts = {3, 1, 1};
  plan_.size_mm = {60, 0, 0};
  std::vector<PointOutcome> outcomes;
  for (int t = 0; t < 2; ++t)
    for (int p = 0; p < 3; ++p)
      outcomes.push_back(outcome(
          3 * t + p, (t == 0 ? 0.999 : 0.997) * plan_.positions()[static_cast<std::size_t>(p)], 19.0, 0.02));
  const VolumeMap map = volume_map(plan_, outcomes);
  EXPECT_NEAR(map.spacings.at(1).error_mm.mean, -0.12, 1e-12);
  EXPECT_NEAR(map.largest_mm.mean, 0.12, 1e-12);
}

TEST_F(VolumeMapTest, WhatFailsIsCountedWithItsReason) {
  plan_.counts = {2, 1, 1};
  plan_.size_mm = {60, 0, 0};
  plan_.trials = 3;
  std::vector<PointOutcome> outcomes;
  for (int t = 0; t < 3; ++t) outcomes.push_back(outcome(2 * t, {-30, 0, 270.0 + t}, 19.0, 0.1));
  PointOutcome lost;
  lost.id = 1;
  lost.failed = true;
  lost.reason = "no camera sees any object";
  outcomes.push_back(lost);
  outcomes.push_back(outcome(3, Vector3d::Constant(NAN), NAN, NAN));  // no usable fit; trial 2 is missing
  const VolumeMap map = volume_map(plan_, outcomes);
  EXPECT_EQ(map.measured, 1u);
  EXPECT_EQ(map.positions[1].n, 0u);
  EXPECT_EQ(map.positions[1].failed, 2u);
  EXPECT_EQ(map.positions[1].reason, "no camera sees any object");
  EXPECT_TRUE(std::isnan(map.positions[1].numbers.at("x_mm").mean));
  EXPECT_EQ(map.spacings[0].error_mm.n, 0u);
  EXPECT_TRUE(std::isnan(map.largest_mm.mean));
  EXPECT_EQ(map.worst.at("z_mm").mean, 0u);
  const auto json = nlohmann::json::parse(volume_map_json(plan_, map));
  EXPECT_TRUE(json["positions"][1]["x_mm"]["mean"].is_null());
  EXPECT_EQ(json["positions"][1]["reason"], "no camera sees any object");
  EXPECT_TRUE(json["spacing"]["worst_mean"].is_null()) << "no spacing was measured";
}

TEST_F(VolumeMapTest, TheWorstIsOfWhatEveryTrialHas) {
  plan_.counts = {3, 1, 1};
  plan_.size_mm = {60, 0, 0};
  plan_.trials = 3;
  // Along x by 0.01 outwards; the last position is far off and lost in the last trial.
  std::vector<PointOutcome> outcomes;
  for (int t = 0; t < 3; ++t) {
    outcomes.push_back(outcome(3 * t, {-30.01, 0, 270}, 19.0, 0.1));
    outcomes.push_back(outcome(3 * t + 1, {0, 0, 270}, 19.0, 0.1));
    if (t < 2) outcomes.push_back(outcome(3 * t + 2, {35, 0, 270}, 19.0, 0.3));
  }
  const VolumeMap map = volume_map(plan_, outcomes);
  EXPECT_EQ(map.measured, 2u);
  EXPECT_EQ(map.worst.at("x_mm").mean, 0u);
  EXPECT_EQ(map.worst.at("form_mm").mean, 0u);
  ASSERT_TRUE(map.worst_spacing);
  EXPECT_EQ(map.worst_spacing->mean, 0u) << "of the first two positions";
  EXPECT_EQ(map.largest_mm.n, 2u);
  EXPECT_NEAR(map.largest_mm.mean, 5.01, 1e-12) << "not of the trial without the last position";
  const auto json = nlohmann::json::parse(volume_map_json(plan_, map));
  EXPECT_EQ(json["spacing"]["largest_mm"]["n"], 2);
  EXPECT_EQ(json["spacing"]["pairs"][1]["n"], 2);
}

TEST_F(VolumeMapTest, TheFileSaysLatticeAndInputs) {
  const std::string head =
      "schema = \"fringetwin-study/1\"\ntwin = \"twin.toml\"\nkind = \"volume-map\"\nobject = \"ball\"\n";
  const std::string lattice = "center_mm = [0, 0, 270]\nsize_mm = [60, 40, 0]\ncounts = [3, 2, 1]\n";
  const auto load = [&](const std::string& text) {
    write_file(folder_ / "study.toml", text);
    return load_study(folder_ / "study.toml");
  };
  const StudyFile study = load(head + lattice +
                               "trials = 7\nseed = 3\nnoise = false\ncoverage = 0.9\n[[uncertain]]\nform = "
                               "\"ball\"\nrms_mm = 0.003\n");
  ASSERT_TRUE(std::holds_alternative<VolumeMapPlan>(study.plan));
  const VolumeMapPlan& plan = std::get<VolumeMapPlan>(study.plan);
  EXPECT_EQ(plan.radius_mm, 19.0);
  EXPECT_THAT(plan.counts, ElementsAre(3, 2, 1));
  EXPECT_EQ(plan.trials, 7u);
  EXPECT_EQ(plan.inputs.forms.size(), 1u);
  EXPECT_EQ(study.head.records.size(), 6u);

  const auto refused = [&](const std::string& text, const std::string& sentence) {
    SCOPED_TRACE(text);
    expect_user_error(ExitCode::usage, sentence, [&] { load(text); });
  };
  refused(
      "schema = \"fringetwin-study/1\"\ntwin = \"twin.toml\"\nkind = \"volume-map\"\nobject = \"bull\"\n" +
          lattice,
      "no sphere of the twin");
  refused(head + "center_mm = [0, 0, 270]\nsize_mm = [60, 40, 0]\ncounts = [3, 2, 2]\n", "must be 1 where");
  refused(head + "center_mm = [0, 0, 270]\nsize_mm = [60, 40, 0]\ncounts = [3, 2.5, 1]\n", "whole numbers");
  refused(head + "center_mm = [0, 0, 270]\nsize_mm = [60, 40, 1]\ncounts = [9, 9, 9]\n", "at most 512");
  refused(head + lattice + "[[record]]\nresult = \"x\"\n", "record");
  refused(head + lattice + "noise = false\n", "nothing is uncertain");
  write_file(folder_ / "twin.toml", small_twin({{"[[measure.fit]]\nobject = \"ball\"\n", ""}}));
  refused(head + lattice, "not fitted by the twin");
}

}  // namespace
}  // namespace fringetwin::testing::volume_map_test
