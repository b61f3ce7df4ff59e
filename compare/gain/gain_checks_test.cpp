// SPDX-License-Identifier: Apache-2.0
// Truth: synthetic images of known gain and black level (tests/support/compare/synthetic_sides.hpp), changed
// by plain factors. | check                              | tolerance    | origin |
// |------------------------------------|--------------|----------------------------------------------------|
// | gain and black level of a part     | 4.5 sigma    | its standard error; 30 of them fail once in 5000   |
// | sigma against sigma/sqrt(n var E)  | 25 %         | 45 blocks give the sandwich about 11 % scatter     |
// | a factor on one half of the image  | and 0.1 %    | half a column of pixels on the wrong side          |
#include "compare/gain/gain_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>

#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gain_checks_test {
namespace {

using testing::deep_truth;
using ::testing::ElementsAre;
using testing::FittedGray;
using ::testing::IsEmpty;
using testing::SidesTruth;
using testing::SyntheticSides;

GainParts parts_of(const FittedGray& gray) {
  return gain_checks(gray.sides.twin.fringes, gray.pair, gray.fit, gray.noise(), gray.pair.mask);
}
GainParts parts_of(SyntheticSides scene) { return parts_of(FittedGray(std::move(scene))); }

GainCheck part(const GainParts& parts, const std::string& name) {
  for (const GainCheck& row : parts.rows)
    if (row.part == name) return row;
  ADD_FAILURE() << "no part " << name;
  return {};
}

void expect_gain(const GainCheck& row, double gain_dn) {
  EXPECT_NEAR(row.gain_dn, gain_dn, 4.5 * row.gain_sigma_dn) << row.part;
}

TEST(GainChecks, AllPartsOfARightTwinSayTheTruth) {
  const SidesTruth t = deep_truth();
  const GainParts parts = parts_of(testing::make_sides(t));
  std::vector<std::string> names;
  for (const GainCheck& row : parts.rows) {
    names.push_back(row.part);
    EXPECT_EQ(row.camera, "left");
    expect_gain(row, t.gain_dn);
    EXPECT_LT(row.gain_sigma_dn, 0.002 * t.gain_dn) << row.part;
    if (row.part != kAllValues) {
      EXPECT_LT(std::abs(row.gain_z), 4.5) << row.part;
    }
    if (row.part == kWithinPixels) continue;
    EXPECT_NEAR(row.black_level_dn, t.black_level_dn, 4.5 * row.black_level_sigma_dn) << row.part;
  }
  EXPECT_THAT(names,
              ElementsAre(kAllValues, kWithinPixels, kBetweenPixels, "left half", "right half", "upper half",
                          "lower half", "dark half", "bright half", kLowValues, kHighValues, "step 1/4",
                          "step 2/4", "step 3/4", "step 4/4", "x pitch 13", "x pitch 14", "x pitch 15"));
  EXPECT_TRUE(std::isnan(part(parts, kWithinPixels).black_level_dn));
  EXPECT_TRUE(std::isnan(part(parts, kAllValues).gain_z));
  EXPECT_EQ(parts.dropped_fraction, 0.0);
}

TEST(GainChecks, SigmaAgreesWithTheClosedFormForIndependentNoise) {
  const SidesTruth t = deep_truth();
  const FittedGray gray(testing::make_sides(t));
  double n = 0, e1 = 0, e2 = 0;
  for (std::size_t i = 0; i < gray.pair.mask.size(); ++i)
    for (const int image : gray.pair.gain_images)
      if (gray.pair.mask.data[i] != 0) {
        const double e = gray.pair.irradiance_at(image, i);
        n += 1, e1 += e, e2 += e * e;
      }
  const GainCheck all = part(parts_of(gray), kAllValues);
  EXPECT_EQ(static_cast<double>(all.n), n);
  const double variance_e = e2 / n - e1 / n * (e1 / n), noise_dn2 = t.noise_dn * t.noise_dn + 1.0 / 12.0;
  EXPECT_NEAR(all.gain_sigma_dn / std::sqrt(noise_dn2 / (n * variance_e)), 1.0, 0.25);
}

TEST(GainChecks, ContrastThatTheTwinLacksPartsModulationFromMeans) {
  const SidesTruth t = deep_truth();
  SyntheticSides scene = testing::make_sides(t);
  std::vector<GrayImage>& images =
      scene.simulated.irradiance[0].images;  // the twin's contrast is 1/0.8 of the real
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    float mean = 0.0F;
    for (const GrayImage& image : images) mean += image[i] / static_cast<float>(images.size());
    for (GrayImage& image : images) image.as_floats()[i] = mean + (image[i] - mean) / 0.8F;
  }
  const GainParts parts = parts_of(scene);
  expect_gain(part(parts, kWithinPixels), 0.8 * t.gain_dn);
  expect_gain(part(parts, kBetweenPixels), t.gain_dn);
  EXPECT_LT(part(parts, kWithinPixels).gain_z, -4.5);
  EXPECT_GT(part(parts, kBetweenPixels).gain_z, 4.5);
}

/// Multiplies the real gray values above black where `is_brighter(image, x)`.
template <class Where>
SyntheticSides brightened(const SidesTruth& t, float factor, Where is_brighter) {
  SyntheticSides scene = testing::make_sides(t);
  const auto black = static_cast<float>(t.black_level_dn);
  std::vector<GrayImage>& images = scene.real.images[0].images;
  for (std::size_t k = 0; k < images.size(); ++k)
    for (int y = 0; y < t.height; ++y)
      for (int x = 0; x < t.width; ++x)
        if (is_brighter(static_cast<int>(k), x))
          images[k].writable(x, y) = black + factor * (images[k](x, y) - black);
  return scene;
}

TEST(GainChecks, ABrighterStepIsSeenInItsStepAlone) {
  const SidesTruth t = deep_truth();
  const GainParts parts = parts_of(brightened(t, 1.02F, [](int image, int) { return image % 4 == 1; }));
  for (const char* name : {"step 1/4", "step 3/4", "step 4/4"}) expect_gain(part(parts, name), t.gain_dn);
  expect_gain(part(parts, "step 2/4"), 1.02 * t.gain_dn);
  EXPECT_GT(part(parts, "step 2/4").gain_z, 4.5);
}

TEST(GainChecks, AResponseThatIsNotStraightPartsLowFromHighValues) {
  const SidesTruth t = deep_truth();
  SyntheticSides scene = testing::make_sides(t);
  for (GrayImage& image : scene.real.images[0].images)
    for (float& y : image.as_floats()) y -= 1e-5F * (y - 400.0F) * (y - 400.0F);  // of up to 2000 DN: 2 %
  const GainParts parts = parts_of(scene);
  const GainCheck low = part(parts, kLowValues), high = part(parts, kHighValues);
  // the slope of x - 1e-5 x^2 at the brightest low value, some 1000 DN, is 2 % below that at black
  EXPECT_GT(low.gain_dn, 0.98 * t.gain_dn);
  EXPECT_LT(high.gain_dn, 0.98 * t.gain_dn);
  EXPECT_GT(low.gain_z, 4.5);
  EXPECT_LT(high.gain_z, -4.5);
}

TEST(GainChecks, ABrighterHalfOfTheImageIsSeenInThatHalf) {
  const SidesTruth t = deep_truth();
  const GainParts parts = parts_of(brightened(t, 1.03F, [&](int, int x) { return x >= t.width / 2; }));
  const GainCheck left = part(parts, "left half"), right = part(parts, "right half");
  EXPECT_NEAR(left.gain_dn, t.gain_dn, 4.5 * left.gain_sigma_dn + 1e-3 * t.gain_dn);
  EXPECT_NEAR(right.gain_dn, 1.03 * t.gain_dn, 4.5 * right.gain_sigma_dn + 1e-3 * t.gain_dn);
  EXPECT_GT(right.gain_z, 4.5);
}

TEST(GainChecks, ValuesThatOnlyTheMarginLeavesOutAreCounted) {
  FittedGray gray(testing::make_sides(deep_truth()));
  gray.fit.usable.low_dn = 1000.0;
  double n = 0, dropped = 0;
  for (std::size_t i = 0; i < gray.pair.mask.size(); ++i)
    for (const int image : gray.pair.gain_images)
      if (gray.pair.mask.data[i] != 0) {
        n += 1;
        if (gray.fit.row.gain_dn * gray.pair.irradiance_at(image, i) + gray.fit.row.black_level_dn < 1000.0)
          dropped += 1;
      }
  EXPECT_GT(dropped, 0.2 * n);
  EXPECT_NEAR(parts_of(gray).dropped_fraction, dropped / n, 1e-12);
}

TEST(GainChecks, DoNotDependOnTheNumberOfThreads) {
  const SyntheticSides scene = testing::make_sides(deep_truth());
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const GainParts one = parts_of(scene);
  omp_set_num_threads(3);
  const GainParts three = parts_of(scene);
  omp_set_num_threads(before);
  ASSERT_EQ(one.rows.size(), three.rows.size());
  for (std::size_t k = 0; k < one.rows.size(); ++k) {
    EXPECT_EQ(one.rows[k].gain_dn, three.rows[k].gain_dn);
    EXPECT_EQ(one.rows[k].gain_sigma_dn, three.rows[k].gain_sigma_dn);
  }
}

TEST(GainChecks, WithoutPixelsThereAreNoParts) {
  const FittedGray gray(testing::make_sides(deep_truth()));
  const ImageU8 none(gray.pair.width(), gray.pair.height(), 0);
  const GainParts parts = gain_checks(gray.sides.twin.fringes, gray.pair, gray.fit, gray.noise(), none);
  EXPECT_THAT(parts.rows, IsEmpty());
  EXPECT_TRUE(std::isnan(parts.dropped_fraction));
}

}  // namespace
}  // namespace fringetwin::compare::gain_checks_test
