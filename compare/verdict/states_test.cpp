// SPDX-License-Identifier: Apache-2.0
// States of rows that are no pass: noise that the images refute, nothing compared, the worst of several.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "compare/comparison.hpp"
#include "compare/verdict/explained.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::states_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

NoiseRow noise_row(double ratio, double sigma) {
  NoiseRow row;
  row.camera = "left";
  row.direction = "x";
  row.sensor_known = true;
  row.gray_ratio = ratio;
  row.gray_ratio_sigma = sigma;
  row.gray_measured_dn = 3.2;
  row.gray_predicted_dn = 3.2 / ratio;
  return row;
}

ExplainedRow passing(const std::string& quantity, const std::string& region, bool states_noise) {
  ExplainedRow row;
  row.quantity = quantity;
  row.region = region;
  row.state = "explained";
  row.states_noise = states_noise;
  return row;
}

TEST(States, NoiseThatTheImagesRefuteMakesTheBudgetTooWide) {
  const std::vector<ExplainedRow> before{passing("gray", "left", false), passing("gray", "left", true),
                                         passing("phase", "left x", true), passing("phase", "left y", true),
                                         passing("phase", "right x", true)};
  const auto states = [&](const NoiseRow& noise) {
    std::vector<ExplainedRow> rows = before;
    hold_against_noise({noise}, rows);
    std::vector<std::string> out;
    for (const ExplainedRow& row : rows) out.push_back(row.state);
    return out;
  };
  const std::string yes = "explained", wide = "budget too wide";
  EXPECT_THAT(states(noise_row(1.0 / 6.0, 0.001)), ::testing::ElementsAre(yes, wide, wide, yes, yes));
  EXPECT_THAT(states(noise_row(0.89, 0.01)), ::testing::ElementsAre(yes, wide, wide, yes, yes));
  for (const NoiseRow& right : {noise_row(0.91, 0.01), noise_row(0.80, 0.1), noise_row(3.0, 0.01)})
    EXPECT_THAT(states(right), ::testing::Each(yes)) << right.gray_ratio;
  NoiseRow rounding = noise_row(0.5, 0.01);  // of a twin that states no noise
  rounding.sensor_known = false;
  EXPECT_THAT(states(rounding), ::testing::Each(yes));
  NoiseRow quiet = noise_row(0.5, 0.01);  // neighbours round alike where there is hardly more than rounding
  quiet.gray_predicted_dn = 0.35;
  EXPECT_THAT(states(quiet), ::testing::Each(yes));
  std::vector<ExplainedRow> rows = before;
  hold_against_noise({noise_row(1.0 / 6.0, 0.001)}, rows);
  EXPECT_NEAR(rows[2].too_wide_factor, 6.0, 1e-9);
  EXPECT_EQ(rows[2].why, "the twin states 6 times the noise that the images have (3.2 DN, not 19.2)");
}

TEST(States, TheWorstRowSpeaksForItsQuantity) {
  const auto of = [](std::vector<const char*> states) {
    std::vector<ExplainedRow> rows{passing("phase", "left x", false)};
    for (const char* state : states) {
      rows.push_back(passing("gray", "left", false));
      rows.back().worsen(state);
    }
    return worst_state(rows, "gray");
  };
  EXPECT_EQ(of({}), "");
  EXPECT_EQ(of({"explained", "explained"}), "explained");
  EXPECT_EQ(of({"explained", "budget too wide", "explained"}), "budget too wide");
  EXPECT_EQ(of({"not compared", "budget too wide", "explained"}), "not compared");
  EXPECT_EQ(of({"not compared", "not explained", "budget too wide"}), "not explained");
}

TEST(States, ACameraWithoutAGainIsNeverAPass) {
  SidesTruth t;
  t.cameras = 2;
  SyntheticSides scene = testing::make_sides(t);
  for (GrayImage& image : scene.real.images[1].images)
    std::ranges::fill(image.as_floats(), 0.0F);  // it saw nothing
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  std::vector<std::string> regions;
  for (const ExplainedRow& row : c.explained)
    if (row.quantity == "gray") regions.push_back(row.region + ": " + row.state);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_EQ(regions[1], "right: not compared");
  EXPECT_NE(c.budget_verdict().gray, "explained");
}

}  // namespace
}  // namespace fringetwin::compare::states_test
