// SPDX-License-Identifier: Apache-2.0
// Truth: rows written by hand, and synthetic images of known gain
// (tests/support/compare/synthetic_sides.hpp). | check                                   | tolerance        |
// origin                                     |
// |-----------------------------------------|------------------|--------------------------------------------|
// | a bias and a widened sigma from rows    | rounding         | closed forms                               |
// | a planted error against what is printed | 3 widened sigmas | required: docs/metrics/gray.md, "Gain"     |
#include "compare/gain/gain_trust.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compare/gain/gain_checks.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gain_trust_test {
namespace {

using ::testing::AllOf;
using testing::deep_truth;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::SidesTruth;
using testing::SyntheticSides;

/// A gain of 300 DN and a black level of 80 DN, whose gray differences are explained.
Comparison good() {
  Comparison c;
  GainRow row;
  row.camera = "left";
  row.usable = true;
  row.gain_dn = 300.0, row.gain_sigma_dn = 0.01;
  row.black_level_dn = 80.0, row.black_level_sigma_dn = 0.05;
  row.r2 = 0.999, row.outlier_fraction = 0.18, row.dropped_fraction = 0.0;
  c.gain = {row};
  ExplainedRow gray;
  gray.quantity = "gray";
  gray.region = "left";
  gray.state = kExplained;
  c.explained = {gray};
  return c;
}

/// Adds a part, whose standard errors are 0.02 and 0.1 DN.
GainCheck& add(Comparison& c, const std::string& part, double gain_dn, double black_level_dn = 80.0) {
  GainCheck row;
  row.camera = "left";
  row.part = part;
  row.gain_dn = gain_dn, row.gain_sigma_dn = 0.02;
  row.black_level_dn = black_level_dn, row.black_level_sigma_dn = 0.1;
  row.sigma_inflation = 1.0;
  if (!c.gain_checks.empty()) {
    row.gain_z = (gain_dn - c.gain_checks[0].gain_dn) / std::hypot(0.02, 0.02);
    row.black_level_z = (black_level_dn - c.gain_checks[0].black_level_dn) / std::hypot(0.1, 0.1);
  }
  c.gain_checks.push_back(row);
  return c.gain_checks.back();
}

GainRow trusted(Comparison& c) {
  trust_gains(c);
  return c.gain[0];
}

TEST(GainTrust, AnExplainedGainWhosePartsAgreeIsASensorValue) {
  Comparison c = good();
  add(c, kAllValues, 300.0);
  add(c, kWithinPixels, 300.05), add(c, kBetweenPixels, 299.96), add(c, "step 2/4", 300.06, 80.3);
  const GainRow row = trusted(c);
  EXPECT_EQ(row.state, "sensor value");
  EXPECT_EQ(row.why, "");
  EXPECT_EQ(row.gain_bias_dn, 0.0);
  EXPECT_EQ(row.gain_total_sigma_dn(), 0.01);
  EXPECT_EQ(row.black_level_total_sigma_dn(), 0.05);
  EXPECT_THAT(c.warnings, IsEmpty());
}

TEST(GainTrust, ASmallDisagreementWidensTheSigma) {
  Comparison c = good();
  add(c, kAllValues, 300.0);
  add(c, "step 2/4", 300.14);  // 4.9 standard errors, and less than 0.05 %
  add(c, "step 3/4", 299.93);  // 2.5: chance
  const GainRow row = trusted(c);
  EXPECT_EQ(row.state, "sensor value");
  EXPECT_NEAR(row.gain_bias_dn, std::sqrt(0.14 * 0.14 - 0.02 * 0.02), 1e-9);
  EXPECT_NEAR(row.gain_total_sigma_dn(), std::hypot(0.01, row.gain_bias_dn), 1e-12);
  EXPECT_THAT(row.why, HasSubstr("step 2/4"));
  EXPECT_THAT(c.warnings, IsEmpty());
}

TEST(GainTrust, WithoutTheVerdictNoGainIsASensorValue) {
  Comparison c = good();
  add(c, kAllValues, 300.0);
  add(c, "step 2/4", 300.05);
  Comparison unjudged = c;
  c.explained[0].worsen(kNotExplained);
  EXPECT_EQ(trusted(c).state, "biased");
  EXPECT_THAT(c.gain[0].why, AllOf(HasSubstr("not \"explained\""), HasSubstr("parts agree")));
  EXPECT_EQ(c.warnings.size(), 1u);
  unjudged.explained.clear();
  EXPECT_EQ(trusted(unjudged).state, "not offered");
  EXPECT_THAT(unjudged.warnings.at(0), HasSubstr("could not be compared"));
}

TEST(GainTrust, TheVerdictOfAnotherCameraDoesNotCount) {
  Comparison c = good();
  add(c, kAllValues, 300.0);
  c.explained[0].region = "right";
  EXPECT_EQ(trusted(c).state, "not offered");
}

TEST(GainTrust, ModulationAndMeansThatDisagreeNameContrastOrLight) {
  for (const bool light : {false, true}) {
    Comparison c = good();
    c.explained[0].worsen(kNotExplained);
    c.gain[0].gain_dn = 215.0;
    add(c, kAllValues, 216.0);
    add(c, kWithinPixels, 210.0);
    add(c, kBetweenPixels, 300.0).sigma_inflation = light ? 20.0 : 1.0;
    const GainRow row = trusted(c);
    EXPECT_EQ(row.state, "biased");
    EXPECT_NEAR(row.gain_bias_dn, 85.0, 1e-5);  // its own standard error takes 2e-6 of it
    ASSERT_EQ(c.warnings.size(), 1u);
    EXPECT_THAT(c.warnings[0],
                AllOf(HasSubstr("left: gain 215 DN is biased by up to 85 DN"),
                      HasSubstr("says 210 DN, their means 300 DN"),
                      HasSubstr(light ? "the modulation's gain is the better one" : "contrast")));
  }
}

TEST(GainTrust, ImagesAndShadingThatDisagreeAreNamed) {
  Comparison images = good();
  add(images, kAllValues, 300.0);
  add(images, "step 2/4", 304.0), add(images, "x pitch 13", 302.0);
  EXPECT_EQ(trusted(images).state, "biased");
  EXPECT_THAT(images.gain[0].why,
              AllOf(HasSubstr("step 2/4 alone says 304"), HasSubstr("from image to image")));

  Comparison shading = good();
  add(shading, kAllValues, 300.0);
  add(shading, "dark half", 305.0, 78.0), add(shading, "bright half", 298.0, 85.0);
  EXPECT_EQ(trusted(shading).state, "biased");
  EXPECT_THAT(shading.gain[0].why, HasSubstr("response of the camera"));
  EXPECT_NEAR(shading.gain[0].black_level_bias_dn, std::sqrt(25.0 - 0.01), 1e-9);

  Comparison half = good();
  add(half, kAllValues, 300.0);
  add(half, "left half", 303.0);
  EXPECT_EQ(trusted(half).state, "biased");
  EXPECT_THAT(half.gain[0].why, HasSubstr("\"left half\" says 303"));
}

TEST(GainTrust, ABlackLevelAloneMayBeBiased) {
  Comparison c = good();
  add(c, kAllValues, 300.0);
  add(c, "upper half", 300.0, 81.0);
  EXPECT_EQ(trusted(c).state, "biased");
  EXPECT_EQ(c.gain[0].gain_bias_dn, 0.0);
}

TEST(GainTrust, ANegativeR2IsNeverOffered) {
  Comparison c = good();
  add(c, kAllValues, 300.0);
  c.gain[0].r2 = -0.2;
  EXPECT_EQ(trusted(c).state, "not offered");
  EXPECT_THAT(c.warnings.at(0), AllOf(HasSubstr("the gain is not offered"), HasSubstr("R2 is -0.200")));
}

TEST(GainTrust, WithoutPartsNothingIsOffered) {
  Comparison c = good();
  EXPECT_EQ(trusted(c).state, "not offered");
  EXPECT_TRUE(std::isnan(c.gain[0].gain_bias_dn));
  EXPECT_EQ(c.gain[0].gain_total_sigma_dn(), 0.01);
  EXPECT_EQ(c.warnings.size(), 1u);
}

TEST(GainTrust, HalfOfTheValuesLeftOutIsSaid) {
  for (const bool weight : {false, true}) {
    Comparison c = good();
    add(c, kAllValues, 300.0);
    (weight ? c.gain[0].outlier_fraction : c.gain[0].dropped_fraction) = 0.6;
    EXPECT_EQ(trusted(c).state, "biased");
    EXPECT_THAT(c.warnings.at(0), AllOf(HasSubstr("gain"), HasSubstr("60 % of the")));
  }
}

TEST(GainTrust, WhatIsNotFittedOrIsJudgedAlreadyStays) {
  Comparison c = good();
  c.gain[0].usable = false;
  EXPECT_EQ(trusted(c).state, "not fitted");
  c.gain[0].usable = true;
  c.gain[0].state = "not offered", c.gain[0].why = "irradiance";
  EXPECT_EQ(trusted(c).why, "irradiance");
  EXPECT_THAT(c.warnings, IsEmpty());
}

Comparison compared(const SyntheticSides& scene) {
  return compare(scene.twin, scene.real, scene.simulated, {});
}

TEST(GainTrust, ARightTwinHasNoWarning) {
  const SidesTruth t = deep_truth();
  const Comparison c = compared(testing::make_sides(t));
  EXPECT_EQ(c.gain.at(0).state, "sensor value") << c.gain[0].why;
  for (const std::string& w : c.warnings) EXPECT_THAT(w, Not(HasSubstr("gain"))) << w;
}

TEST(GainTrust, AFlickerIsSaidAndCovered) {
  const SidesTruth t = deep_truth();
  SyntheticSides scene = testing::make_sides(t);
  for (const std::size_t image : {1U, 5U, 9U})
    for (float& y : scene.real.images[0].images[image].as_floats()) y = 400.0F + 1.02F * (y - 400.0F);
  const Comparison c = compared(scene);
  const GainRow& row = c.gain.at(0);
  EXPECT_EQ(row.state, "biased");
  EXPECT_GT(std::abs(row.gain_dn - t.gain_dn), 3.0 * row.gain_sigma_dn);  // the plain sigma does not cover it
  EXPECT_LT(std::abs(row.gain_dn - t.gain_dn), 3.0 * row.gain_total_sigma_dn());
  EXPECT_THAT(row.why, HasSubstr("step 2/4"));
}

TEST(GainTrust, AlbedoThatBiasesTheLineIsSaid) {
  SidesTruth t = deep_truth();
  t.albedo_sigma = 0.05;
  const Comparison c = compared(testing::make_sides(t));
  EXPECT_EQ(c.gain.at(0).state, "biased");
  EXPECT_THAT(c.gain[0].why, HasSubstr("albedo or shading scatters by"));
  EXPECT_NEAR(c.gain[0].gain_bias_dn, t.albedo_sigma * t.gain_dn, 0.1 * t.albedo_sigma * t.gain_dn);
}

TEST(GainTrust, MostOfASmallResidualIsNoReasonToDoubtTheLine) {
  SidesTruth t;
  t.noise_dn = 0.3;
  t.albedo_sigma = 0.01;  // of some 100 DN: more than the noise, and nothing to the gain
  const Comparison c = compared(testing::make_sides(t));
  ASSERT_EQ(c.gray_budget.size(), 1u);
  EXPECT_GT(c.gray_budget[0].albedo_dn2 / c.gray_budget[0].total_dn2, 0.5);
  EXPECT_NEAR(c.gray_budget[0].albedo_sigma, 0.01, 0.001);
  EXPECT_NEAR(c.gain[0].gain_dn / t.gain_dn, 1.0, 1e-3);
  EXPECT_THAT(c.gain[0].why, Not(HasSubstr("albedo or shading scatters by")));
}

}  // namespace
}  // namespace fringetwin::compare::gain_trust_test
