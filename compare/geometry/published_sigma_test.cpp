// SPDX-License-Identifier: Apache-2.0
// Truth: the closed form for a whole sphere; tolerance 1 % (points drawn at random: sums to 1/sqrt(n) = 0.5
// %).
#include "compare/geometry/published_sigma.hpp"

#include <gtest/gtest.h>

#include <random>

#include "compare/geometry/fit_rows.hpp"
#include "compare/verdict/explained.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::published_sigma_test {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kPoints = 40'000;
constexpr double kRms = 0.013;

struct Case {
  measure::PointCloud cloud;
  measure::ObjectFit simulated, real;
};

/// Points all over a sphere: sum of u u^T = n/3, so a centre's component is known to s sqrt(3/n), a radius to
/// s/sqrt(n).
Case whole_sphere() {
  Case c;
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  const Vector3d center_mm(6.5, -5.5, 270.6);
  c.simulated.object = c.real.object = "ball";
  c.simulated.kind = c.real.kind = "sphere";
  c.simulated.usable = c.real.usable = true;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Vector3d u = Vector3d(normal(random), normal(random), normal(random)).normalized();
    c.cloud.p_world_mm.push_back(center_mm + 19.0 * u);
    c.simulated.index.push_back(i);
  }
  c.simulated.n = kPoints;
  c.simulated.numbers = {{"radius_mm", 19.0}, {"radius_sigma_mm", 1e-4}, {"rms_mm", 0.004}};
  c.simulated.vectors = {{"center_mm", center_mm}, {"center_sigma_mm", Vector3d::Constant(2e-4)}};
  c.real.numbers = {{"radius_mm", 18.9999}, {"rms_mm", kRms}};
  c.real.vectors = {{"center_mm", center_mm + Vector3d(0.0, 0.0, 0.001)}};
  return c;
}

TEST(PublishedSigma, OfAWholeSphere) {
  const Case c = whole_sphere();
  FitRow row = make_fit_row(c.simulated, c.real);
  estimate_published_z(c.cloud, row);
  const double radius = kRms / std::sqrt(double(kPoints)), center = radius * std::sqrt(3.0);
  EXPECT_NEAR(row.real_sigma_estimated.at("radius_sigma_mm"), radius, 0.01 * radius);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(row.real_sigma_estimated_vectors.at("center_sigma_mm")[i], center, 0.01 * center);
  EXPECT_NEAR(row.z_estimated.at("radius_mm"), 1e-4 / std::hypot(1e-4, radius), 0.01);
  EXPECT_NEAR(row.z_estimated_vectors.at("center_mm").z(), -1e-3 / std::hypot(2e-4, center), 0.05);
  EXPECT_FALSE(row.z_estimated.contains("rms_mm"));
  EXPECT_TRUE(row.z.empty());  // what is unknown stays unknown
  EXPECT_TRUE(row.z_vectors.empty());
}

// The six ends of the axes: sum of u u^T = 2, of u = 0; six residuals of four parameters leave two degrees of
// freedom, s^2 = 6/2 rms^2.
TEST(PublishedSigma, OfFewPointsHasTheirDegreesOfFreedom) {
  Case c = whole_sphere();
  const Vector3d center_mm = c.simulated.vectors.at("center_mm");
  c.cloud.p_world_mm.clear();
  for (int i = 0; i < 3; ++i)
    for (const double side : {-19.0, 19.0})
      c.cloud.p_world_mm.push_back(center_mm + side * Vector3d::Unit(i));
  c.simulated.index = {0, 1, 2, 3, 4, 5};
  FitRow row = make_fit_row(c.simulated, c.real);
  estimate_published_z(c.cloud, row);
  EXPECT_NEAR(row.real_sigma_estimated.at("radius_sigma_mm"), kRms * std::sqrt(3.0 / 6.0), 1e-12);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(row.real_sigma_estimated_vectors.at("center_sigma_mm")[i], kRms * std::sqrt(3.0 / 2.0),
                1e-12);
}

TEST(PublishedSigma, GeometryIsJudgedByIt) {
  const Case c = whole_sphere();
  FitRow row = make_fit_row(c.simulated, c.real);
  EXPECT_EQ(explain_geometry({row}).at(0).state, "not compared");
  estimate_published_z(c.cloud, row);
  const auto explained = explain_geometry({row});
  ASSERT_EQ(explained.size(), 1u);
  EXPECT_EQ(explained[0].worst, "center_mm.z");
  EXPECT_EQ(explained[0].n, 4u);
  const double center = kRms * std::sqrt(3.0 / double(kPoints));
  EXPECT_NEAR(explained[0].chi2, 1e-6 / (4e-8 + center * center), 0.5);  // 19, above 9
  EXPECT_EQ(explained[0].state, "not explained");
  ASSERT_EQ(explained[0].lines.size(), 2u);
  EXPECT_EQ(explained[0].lines[1].name, "fit of the real points, estimated from the published rms");
  EXPECT_NEAR(explained[0].lines[1].variance, center * center, 0.02 * center * center);
}

TEST(PublishedSigma, NothingIsEstimatedWhereItIsKnownOrCannotBe) {
  Case c = whole_sphere();
  c.real.numbers["radius_sigma_mm"] = 2e-4;
  FitRow row = make_fit_row(c.simulated, c.real);
  estimate_published_z(c.cloud, row);
  EXPECT_TRUE(row.z.contains("radius_mm"));
  EXPECT_TRUE(row.z_estimated.empty());
  EXPECT_EQ(row.z_estimated_vectors.size(), 1u);
  c = whole_sphere();
  c.real.numbers.erase("rms_mm");
  row = make_fit_row(c.simulated, c.real);
  estimate_published_z(c.cloud, row);
  EXPECT_TRUE(row.z_estimated.empty() && row.z_estimated_vectors.empty());
}

TEST(PublishedSigma, OnlyPublishedFitsGetOne) {
  testing::SyntheticSides scene = testing::make_sides({});
  std::vector<std::string> warnings;
  for (auto& fit : scene.real.measurement->fits) fit.numbers.erase("radius_sigma_mm");
  EXPECT_TRUE(fit_rows(scene.twin, scene.real, scene.simulated, warnings).at(0).z_estimated.empty());
  scene.real = {};
  scene.twin.real.results.push_back({"ball", {{"radius_mm", 19.065}, {"rms_mm", 0.013}}, {}});
  EXPECT_TRUE(std::isfinite(
      fit_rows(scene.twin, scene.real, scene.simulated, warnings).at(0).z_estimated.at("radius_mm")));
}

}  // namespace
}  // namespace fringetwin::compare::published_sigma_test
