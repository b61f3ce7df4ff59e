// SPDX-License-Identifier: Apache-2.0
// result.json against docs/result.schema.json and against the comparison it was made from.
#include "compare/result/result_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>

#include "tests/support/compare/schema_check.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::result_json_test {
namespace {

using ::testing::IsEmpty;
using testing::Json;

testing::SchemaChecker result_schema() {
  const char* root = std::getenv("FRINGETWIN_SOURCE");
  std::ifstream in(std::filesystem::path(root ? root : ".") / "docs/result.schema.json");
  return testing::SchemaChecker(Json::parse(in));
}

RenderNote example_note() {
  return {.camera = "left",
          .sampler = "adaptive",
          .samples = {},
          .rays_per_pixel = 2.7,
          .phase_error_rad = 3e-5,
          .gray_error = 6e-5,
          .gray_inside_error = 2e-6};
}

Provenance example_provenance() {
  const auto file = std::filesystem::temp_directory_path() / "fringetwin_result_json_input";
  std::ofstream(file) << "abc";
  return {{"fringetwin", "cosim", "twin \"ä\".toml"},
          "0.1.0",
          sha256_of_files({file}),
          "llvmpipe",
          {example_note()},
          7};
}

Json parse(const std::string& text) {
  EXPECT_FALSE(std::regex_search(text, std::regex("[:\\[,]\\s*-?(nan|inf)")));
  return Json::parse(text);
}

TEST(ResultJson, AComparisonFollowsTheSchema) {
  testing::SidesTruth t;
  t.cameras = 2;
  testing::SyntheticSides scene = testing::make_sides(t);
  scene.twin.limits = {{"center_mm", 0.001}, {"gain_r2", 0.9}};
  scene.real.measurement->fits[0].bias = {{"radius_mm", 0.0015}};
  scene.real.measurement->fits[0].numbers["radius_noise_sigma_mm"] = 0.0003;
  scene.simulated.measurement->fits[0].bias = {{"radius_mm", 0.0016}};
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  const Json json =
      parse(comparison_json(scene.twin, c, example_provenance(), {{"render", 1.5}, {"measure", 0.25}}));
  EXPECT_THAT(result_schema().check(json), IsEmpty());
  EXPECT_EQ(json["gain"].size(), 2u);
  EXPECT_EQ(json["gray"].size(), 24u);
  EXPECT_EQ(json["phase"].size(), 2u);
  EXPECT_EQ(json["gray_budget"].size(), 2u);
  EXPECT_EQ(json["noise"].size(), 2u);
  EXPECT_EQ(json["shift"].size(), 2u);
  ASSERT_EQ(json["indicators"].size(), 3u);  // form, its 95 %, size of one sphere
  EXPECT_EQ(json["indicators"][2]["name"].get<std::string>(), "sphere_size");
  EXPECT_NEAR(json["indicators"][2]["z"].get<double>(), 0.0001 / std::hypot(0.0004, 0.0004), 1e-6);
  EXPECT_TRUE(json["indicators"][0]["z"].is_null());
  EXPECT_TRUE(json["shift"][0]["dy_px"].is_null());  // vertical fringes
  EXPECT_EQ(json["fits"][0]["alignment"].get<std::string>(), "none: both sides in the rig's frame");
  EXPECT_EQ(json["verdict"].get<std::string>(), "pass");
  EXPECT_EQ(json["gain"][0]["gain_dn"].get<double>(), c.gain[0].gain_dn);  // every digit
  EXPECT_EQ(json["fits"][0]["simulated"]["center_mm"].size(), 3u);
  EXPECT_NEAR(json["fits"][0]["difference"]["center_mm"][2].get<double>(), -0.0002, 1e-9);
  EXPECT_NEAR(json["fits"][0]["z"]["radius_mm"].get<double>(), 0.0001 / std::hypot(0.0004, 0.0004), 1e-6);
  EXPECT_TRUE(json["fits"][0]["z"]["rms_mm"].is_null());
  EXPECT_EQ(json["fits"][0]["method_bias"].dump(), R"({"radius_mm":0.0015})");  // of the real fit
  EXPECT_EQ(json["fits"][0]["real"]["radius_noise_sigma_mm"].get<double>(), 0.0003);
  EXPECT_FALSE(json["fits"][0]["difference"].contains("radius_noise_sigma_mm"));
  const Json& rendered = json["provenance"]["rendered"][0];
  EXPECT_EQ(rendered["sampler"].get<std::string>(), "adaptive");
  EXPECT_EQ(rendered["estimated_gray_error"].get<double>(), 6e-5);
  EXPECT_EQ(rendered["estimated_gray_error_inside"].get<double>(), 2e-6);
  EXPECT_FALSE(rendered.contains("samples"));
  EXPECT_EQ(json["provenance"]["argv"][2].get<std::string>(), "twin \"ä\".toml");
  EXPECT_EQ(json["provenance"]["inputs_sha256"].begin().value(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(ResultJson, PublishedNumbersOnly) {
  testing::SidesTruth t;
  t.published_only = true;
  testing::SyntheticSides scene = testing::make_sides(t);
  scene.twin.real.results.push_back(
      {"ball", {{"radius_mm", 19.065}}, {{"center_mm", {6.567, -5.497, 270.634}}}});
  scene.twin.limits = {{"phase_rms_rad", 0.01}};
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  const Json json = parse(comparison_json(scene.twin, c, {}, {}));
  EXPECT_THAT(result_schema().check(json), IsEmpty());
  EXPECT_EQ(json["fits"][0]["real"]["n"].get<int>(), 0);
  EXPECT_TRUE(json["fits"][0]["real"]["radius_sigma_mm"].is_null());
  EXPECT_TRUE(json["fits"][0]["real"]["rms_mm"].is_null());
  EXPECT_TRUE(json["limits"][0]["value"].is_null());
  EXPECT_EQ(json["verdict"].get<std::string>(), "fail");
  EXPECT_THAT(json["gain"], IsEmpty());
  EXPECT_TRUE(json["provenance"]["device"].is_null());
}

TEST(ResultJson, AFitWithTooFewPointsHasNullsAndItsCount) {
  testing::SyntheticSides scene = testing::make_sides({});
  auto& fit = scene.simulated.measurement->fits[0];
  fit.usable = false;
  fit.n = 2;
  fit.warning = "2 points are too few";
  fit.numbers.clear();
  fit.vectors.clear();
  const Json json =
      parse(measurement_json(scene.twin, *scene.simulated.measurement, example_provenance(), {}));
  EXPECT_THAT(result_schema().check(json), IsEmpty());
  const Json& measured = json["fits"][0]["measured"];
  EXPECT_TRUE(measured["radius_mm"].is_null());
  EXPECT_TRUE(measured["center_mm"].is_null());
  EXPECT_EQ(measured["n"].get<int>(), 2);
  EXPECT_EQ(measured["warning"].get<std::string>(), "2 points are too few");
}

TEST(ResultJson, NonFiniteNumbersBecomeNull) {
  testing::SyntheticSides scene = testing::make_sides({});
  auto& fit = scene.simulated.measurement->fits[0];
  fit.numbers["radius_mm"] = std::numeric_limits<double>::infinity();
  fit.vectors["center_mm"].x() = std::nan("");
  const Json json =
      parse(measurement_json(scene.twin, *scene.simulated.measurement, {}, {{"x", std::nan("")}}));
  EXPECT_TRUE(json["fits"][0]["measured"]["radius_mm"].is_null());
  EXPECT_TRUE(json["fits"][0]["measured"]["center_mm"][0].is_null());
  EXPECT_TRUE(json["fits"][0]["measured"]["center_mm"][1].is_number());
}

TEST(ResultJson, TheCheckerItselfFindsFaults) {
  const testing::SchemaChecker checker = result_schema();
  testing::SyntheticSides scene = testing::make_sides({});
  Json json = parse(measurement_json(scene.twin, *scene.simulated.measurement, {}, {}));
  EXPECT_THAT(checker.check(json), IsEmpty());
  json["verdict"] = "maybe";
  json.erase("gain");
  json["fits"][0]["measured"]["radius_mm"] = "19";
  json["surprise"] = 1;
  EXPECT_EQ(checker.check(json).size(), 4u);
}

}  // namespace
}  // namespace fringetwin::compare::result_json_test
