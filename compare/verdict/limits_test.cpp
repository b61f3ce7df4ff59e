// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/compare/synthetic_sides.hpp"
#include "tests/support/twin/twin_file_fixture.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare::limits_test {
namespace {

Comparison example() {
  Comparison c;
  FitRow row;
  row.object = "ball";
  row.kind = "sphere";
  row.difference = {{"radius_mm", -0.004}};
  row.difference_vectors = {{"center_mm", {0.001, -0.008, 0.002}}};
  row.simulated.emplace();
  row.simulated->usable = true;
  row.simulated->numbers = {{"rms_mm", 0.0038}, {"rms_all_mm", 0.0041}};
  c.fits.push_back(row);
  c.phase = {{"left", "x", 0, 0.01, 0.02, 1e-4, 10, 0}, {"right", "x", 0, 0.03, 0.05, 2e-4, 10, 30}};
  for (double r2 : {0.999, 0.99}) {
    GainRow gain;
    gain.r2 = r2;
    gain.rms_after_dn = 100.0 * (1.0 - r2);
    c.gain.push_back(gain);
  }
  NoiseRow noise;
  noise.gray_ratio = 1.02;
  noise.phase_ratio = 0.75;
  c.noise.push_back(noise);
  return c;
}

LimitRow check(const std::string& name, double limit, const Comparison& c = example()) {
  return check_limits({{name, limit}}, c).at(0);
}

TEST(Limits, TakeTheWorstOfAllRows) {
  EXPECT_DOUBLE_EQ(check("center_mm", 1).value, 0.008);
  EXPECT_DOUBLE_EQ(check("radius_mm", 1).value, 0.004);
  EXPECT_DOUBLE_EQ(check("rms_mm", 1).value, 0.0038);
  EXPECT_DOUBLE_EQ(check("rms_all_mm", 1).value, 0.0041);
  EXPECT_DOUBLE_EQ(check("order_disagree_fraction", 1).value, 0.75);
  EXPECT_DOUBLE_EQ(check("phase_rms_rad", 1).value, 0.03);
  EXPECT_DOUBLE_EQ(check("phase_mean_relative", 1).value, 2e-4);
  EXPECT_NEAR(check("gray_rms_dn", 1).value, 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(check("noise_ratio_error", 1).value, 0.25);
  EXPECT_DOUBLE_EQ(check("gain_r2", 0.5).value, 0.99);
}

TEST(Limits, TheLimitItselfPasses) {
  EXPECT_TRUE(check("center_mm", 0.008).pass);
  EXPECT_FALSE(check("center_mm", 0.0079999).pass);
  EXPECT_TRUE(check("gain_r2", 0.99).pass);
  EXPECT_FALSE(check("gain_r2", 0.9901).pass);
}

TEST(Limits, WhatCannotBeCheckedIsNotMet) {
  const LimitRow row = check("phase_rms_rad", 1.0, Comparison{});
  EXPECT_TRUE(std::isnan(row.value));
  EXPECT_FALSE(row.pass);
  Comparison c = example();
  c.fits[0].difference_vectors.clear();  // a sphere without a centre difference
  EXPECT_FALSE(check("center_mm", 1.0, c).pass);
}

using LimitNames = testing::TwinFile;
using testing::kMinimal;

std::string refusal(const Twin& twin) {
  try {
    check_limit_names(twin);
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  ADD_FAILURE() << "every limit was accepted";
  return "";
}

TEST_F(LimitNames, EveryNameWithAValueIsAccepted) {
  std::string text = kMinimal + "[limits]\n";
  for (const auto& [name, limit] : limits_by_name()) text += name + " = 0.5\n";
  const Twin twin = load(text);
  EXPECT_EQ(twin.limits.size(), limits_by_name().size());
  EXPECT_EQ(twin.limits.at("noise_ratio_error"), 0.5);
  EXPECT_NO_THROW(check_limit_names(twin));
}

TEST_F(LimitNames, AnUnknownOneIsRefusedWithFileLineAndTheNearest) {
  const Twin twin = load("\n" + kMinimal + "[limits]\ngain_r2 = 0.9\nphase_rms = 1\n");
  const auto line = std::count(kMinimal.begin(), kMinimal.end(), '\n') + 4;
  EXPECT_THAT(refusal(twin), ::testing::AllOf(::testing::HasSubstr((folder_ / "twin.toml").string() + ":" +
                                                                   std::to_string(line) + ": "),
                                              ::testing::HasSubstr("unknown key \"phase_rms\" in [limits]"),
                                              ::testing::HasSubstr("did you mean \"phase_rms_rad\"?")));
  EXPECT_THAT(refusal(load(kMinimal + "[limits]\nsurprise = 1\n")),
              ::testing::HasSubstr("known keys: center_mm, covered_fraction, gain_r2, "));
}

TEST_F(LimitNames, ACorrelationAboveOneIsRefused) {
  EXPECT_THAT(refusal(load(kMinimal + "[limits]\ngain_r2 = 1.5\n")),
              ::testing::HasSubstr("must be >= 0 and <= 1, is 1.5"));
}

TEST(Limits, DecideTheVerdict) {
  testing::SyntheticSides scene = testing::make_sides({});
  EXPECT_TRUE(compare(scene.twin, scene.real, scene.simulated, {}).pass);
  scene.twin.limits = {{"radius_mm", 0.001}, {"gain_r2", 0.99}};
  EXPECT_TRUE(compare(scene.twin, scene.real, scene.simulated, {}).pass);
  scene.twin.limits["center_mm"] = 0.0001;
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  EXPECT_FALSE(c.pass);
  EXPECT_EQ(c.limits.size(), 3u);
}

}  // namespace
}  // namespace fringetwin::compare::limits_test
