// SPDX-License-Identifier: Apache-2.0
// Truth: closed forms; tolerance 1e-9 mm (double rounding), 1e-6 where a deviation is stored as float.
#include "compare/verdict/indicators.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::indicators_test {
namespace {

using measure::ObjectFit;

ObjectFit sphere(const std::string& name, const Eigen::Vector3d& center_mm, double radius_mm) {
  ObjectFit fit;
  fit.object = name;
  fit.kind = "sphere";
  fit.usable = true;
  fit.numbers = {{"radius_mm", radius_mm}, {"radius_sigma_mm", 0.0003}};
  fit.vectors = {{"center_mm", center_mm}, {"center_sigma_mm", {0.001, 0.002, 0.004}}};
  fit.deviation_mm = {-0.002f, 0.0f, 0.003f};
  return fit;
}

FitRow row(const std::optional<ObjectFit>& simulated, const std::optional<ObjectFit>& real) {
  FitRow out;
  out.object = (simulated ? *simulated : *real).object;
  out.kind = (simulated ? *simulated : *real).kind;
  out.simulated = simulated;
  out.real = real;
  return out;
}

Twin twin_of(std::vector<Object> objects) {
  Twin twin;
  twin.objects = std::move(objects);
  return twin;
}

const Indicator* find(const std::vector<Indicator>& rows, const std::string& name) {
  const auto at = std::find_if(rows.begin(), rows.end(), [&](const Indicator& i) { return i.name == name; });
  return at == rows.end() ? nullptr : &*at;
}

TEST(Indicators, RangesOfARamp) {
  // 0 ... 99: 95 neighbours span 94, wherever they start; all span 99.
  std::vector<float> ramp(100);
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<float>(i);
  std::shuffle(ramp.begin(), ramp.end(), std::mt19937(1));
  EXPECT_EQ(deviation_ranges(ramp).all_mm, 99.0);
  EXPECT_EQ(deviation_ranges(ramp).p95_mm, 94.0);
}

TEST(Indicators, FiveOutliersOfAHundredAreNotInThe95PercentRange) {
  std::vector<float> d(100, 0.0f);
  for (std::size_t i = 0; i < 95; ++i) d[i] = (i % 2 == 0 ? 1e-3f : -1e-3f);
  for (std::size_t i = 95; i < 100; ++i) d[i] = (i == 99 ? -0.5f : 0.4f);  // on both sides
  EXPECT_NEAR(deviation_ranges(d).all_mm, 0.9, 1e-6);
  EXPECT_NEAR(deviation_ranges(d).p95_mm, 0.002, 1e-6);
  d[0] = 0.4f;  // a sixth one cannot be left out
  EXPECT_NEAR(deviation_ranges(d).p95_mm, 0.401, 1e-6);
}

TEST(Indicators, NormalDeviationsGiveTheNormalQuantiles) {
  // +-1.95996 sigma. The shortest interval of n = 4e5 is about 1 % narrower at most: its ends scatter by
  // sqrt(0.025 * 0.975 / n) / density(1.96) = 0.004 sigma each, and the shortest is taken.
  std::vector<float> d(400'000);
  std::mt19937_64 random(3);
  std::normal_distribution<float> normal(0.0f, 0.01f);
  for (float& x : d) x = normal(random);
  EXPECT_NEAR(deviation_ranges(d).p95_mm, 2.0 * 1.959964 * 0.01, 0.01 * 0.04);
}

TEST(Indicators, NoDeviationsNoRange) {
  EXPECT_TRUE(std::isnan(deviation_ranges({}).all_mm));
  EXPECT_EQ(deviation_ranges({0.25f}).p95_mm, 0.0);
}

TEST(Indicators, SphereFormAndSize) {
  const Twin twin = twin_of({{"ball", SphereShape{{0, 0, 300}, 10.0}, {}}});
  const auto rows =
      indicators(twin, {row(sphere("ball", {0, 0, 300}, 10.002), sphere("ball", {0, 0, 300}, 9.999))});
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_NEAR(find(rows, "sphere_form")->simulated.mm, 0.005, 1e-6);
  EXPECT_TRUE(std::isnan(find(rows, "sphere_form")->z()));
  const Indicator& size = *find(rows, "sphere_size");
  EXPECT_NEAR(size.simulated.mm, 0.004, 1e-9);  // of the diameter
  EXPECT_NEAR(size.real.mm, -0.002, 1e-9);
  EXPECT_NEAR(size.difference_mm(), 0.006, 1e-9);
  EXPECT_NEAR(size.simulated.sigma_mm, 0.0006, 1e-12);
  EXPECT_NEAR(size.z(), 0.006 / (0.0006 * std::sqrt(2.0)), 1e-6);
}

TEST(Indicators, SpacingIsAlongTheLineOfTheCentres) {
  const Twin twin =
      twin_of({{"a", SphereShape{{0, 0, 300}, 5}, {}}, {"b", SphereShape{{30, 0, 340}, 5}, {}}});
  // the second sphere 0.01 mm further along the line (0.6, 0, 0.8), and off it, which the distance hardly
  // sees
  const ObjectFit a = sphere("a", {0, 0, 300}, 5);
  ObjectFit b = sphere("b", {30.006, 0, 340.008}, 5);
  b.vectors["center_sigma_mm"] *= 2.0;
  const ObjectFit beside = sphere("b", {30.0, 0.01, 340.0}, 5);
  const auto rows = indicators(twin, {row(a, a), row(b, beside)});
  const Indicator* spacing = find(rows, "sphere_spacing");
  ASSERT_NE(spacing, nullptr);
  EXPECT_EQ(spacing->objects, (std::vector<std::string>{"a", "b"}));
  EXPECT_NEAR(spacing->simulated.mm, 0.01, 1e-9);
  EXPECT_NEAR(spacing->real.mm, std::hypot(50.0, 0.01) - 50.0, 1e-9);
  // of the first centre (0.6 * 0.001)^2 + (0.8 * 0.004)^2, of the second four times that
  EXPECT_NEAR(spacing->simulated.sigma_mm, std::sqrt(5.0) * std::hypot(0.0006, 0.0032), 1e-8);
}

TEST(Indicators, PlanesHaveFlatnessAndNoSize) {
  ObjectFit plane;
  plane.object = "wall";
  plane.kind = "plane";
  plane.usable = true;
  plane.deviation_mm = {-0.001f, 0.004f};
  const Twin twin = twin_of({{"wall", PlaneShape{{0, 0, 300}, {0, 0, -1}, {}, {1, 0, 0}}, {}}});
  const auto rows = indicators(twin, {row(plane, {})});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(find(rows, "plane_flatness")->simulated.mm, 0.005, 1e-6);
  EXPECT_TRUE(std::isnan(find(rows, "plane_flatness")->real.mm));
}

TEST(Indicators, PublishedNumbersHaveSizesButNoForm) {
  ObjectFit published = sphere("ball", {0, 0, 300}, 10.001);
  published.deviation_mm.clear();
  published.numbers.erase("radius_sigma_mm");
  const Twin twin = twin_of({{"ball", SphereShape{{0, 0, 300}, 10.0}, {}}});
  const auto rows = indicators(twin, {row(sphere("ball", {0, 0, 300}, 10.0), published)});
  EXPECT_TRUE(std::isnan(find(rows, "sphere_form")->real.mm));
  EXPECT_NEAR(find(rows, "sphere_size")->real.mm, 0.002, 1e-9);
  EXPECT_TRUE(std::isnan(find(rows, "sphere_size")->z()));
}

TEST(Indicators, OfAWholeComparison) {
  // 0.004 and 0.013 mm of normal noise went in: 95 % of the points span 3.92 sigma, to 5 % (some 10^4
  // points).
  const testing::SyntheticSides scene = testing::make_sides({});
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  const Indicator* form = find(c.indicators, "sphere_form_95");
  ASSERT_NE(form, nullptr);
  EXPECT_NEAR(form->simulated.mm, 3.92 * 0.004, 0.05 * 3.92 * 0.004);
  EXPECT_NEAR(form->real.mm, 3.92 * 0.013, 0.05 * 3.92 * 0.013);
  EXPECT_GT(find(c.indicators, "sphere_form")->real.mm, 6.0 * 0.013);  // extremes of as many points
}

}  // namespace
}  // namespace fringetwin::compare::indicators_test
