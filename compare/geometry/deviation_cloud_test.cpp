// SPDX-License-Identifier: Apache-2.0
// Truth: deviations that are put in, and ColorBrewer's published colours of RdBu (its two ends and the white
// between them), which must come out to the bit. Files hold single precision, and so do the inputs.
#include "compare/geometry/deviation_cloud.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "tests/support/measure/read_ply.hpp"

namespace fringetwin::compare::deviation_cloud_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Four points, of which a fit uses three, at these distances.
measure::Measurement side(std::vector<float> deviation_mm) {
  measure::Measurement m;
  for (int i = 0; i < 4; ++i) {
    m.cloud.p_world_mm.emplace_back(i, 10 + i, 250);
    m.cloud.normal_world.emplace_back(0, 0, -1);
    m.cloud.q_cam_px.emplace_back(i, 0);
    m.cloud.sigma_mm.push_back(0.25F * static_cast<float>(i));
  }
  measure::ObjectFit fit;
  fit.object = "ball";
  fit.kind = "sphere";
  fit.usable = true;
  fit.index = {0, 1, 3};
  fit.deviation_mm = std::move(deviation_mm);
  m.fits.push_back(fit);
  return m;
}

class DeviationCloud : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(dir_); }
  void TearDown() override { std::filesystem::remove_all(dir_); }
  std::filesystem::path dir_ =
      std::filesystem::temp_directory_path() / ("fringetwin_deviation_" + std::to_string(::getpid()));
};

TEST_F(DeviationCloud, PointsHaveTheirDeviationAndItsColour) {
  const measure::Measurement m = side({-0.5F, 0.0F, 0.5F});  // two of three at 0.5: so is the 99th percentile
  write_deviation_clouds(dir_, m, {&m});
  const auto ply = fringetwin::testing::read_ply_points(dir_ / "deviation_ball.ply");
  ASSERT_TRUE(ply.complete);
  EXPECT_THAT(ply.names, ElementsAre("x", "y", "z", "nx", "ny", "nz", "scalar_sigma_mm",
                                     "scalar_deviation_mm", "red", "green", "blue"));
  EXPECT_THAT(ply.values.at("x"), ElementsAre(0, 1, 3));
  EXPECT_THAT(ply.values.at("y"), ElementsAre(10, 11, 13));
  EXPECT_THAT(ply.values.at("scalar_sigma_mm"), ElementsAre(0, 0.25, 0.75));
  EXPECT_THAT(ply.values.at("scalar_deviation_mm"), ElementsAre(-0.5, 0, 0.5));
  EXPECT_EQ(ply.type.at("red"), "uchar");
  EXPECT_THAT(ply.values.at("red"), ElementsAre(5, 255, 103));
  EXPECT_THAT(ply.values.at("green"), ElementsAre(48, 255, 0));
  EXPECT_THAT(ply.values.at("blue"), ElementsAre(97, 255, 31));
  EXPECT_THAT(ply.comment, HasSubstr("fitted sphere: blue -0.5 mm, white 0, red 0.5 mm"));
}

// The same distance has the same colour on both sides, of which one has larger ones: 0.4 of the span is the
// second class from white of RdBu's eleven.
TEST_F(DeviationCloud, BothSidesHaveOneScale) {
  const measure::Measurement small = side({-0.25F, 0.0F, 0.25F}), large = side({-0.625F, 0.0F, 0.625F});
  write_deviation_clouds(dir_, small, {&small, &large});
  const auto ply = fringetwin::testing::read_ply_points(dir_ / "deviation_ball.ply");
  EXPECT_THAT(ply.comment, HasSubstr("red 0.625 mm"));
  EXPECT_THAT(ply.values.at("red"), ElementsAre(146, 255, 244));
  EXPECT_THAT(ply.values.at("green"), ElementsAre(197, 255, 165));
  EXPECT_THAT(ply.values.at("blue"), ElementsAre(222, 255, 130));
}

TEST_F(DeviationCloud, AFitWithoutDeviationsLeavesNoFile) {
  measure::Measurement m = side({-0.5F, 0.0F, 0.5F});
  m.fits[0].usable = false;
  write_deviation_clouds(dir_, m, {&m});
  EXPECT_TRUE(std::filesystem::is_empty(dir_));
  EXPECT_EQ(fit_with_deviations(m, "ball"), nullptr);
}

}  // namespace
}  // namespace fringetwin::compare::deviation_cloud_test
