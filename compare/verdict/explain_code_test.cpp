// SPDX-License-Identifier: Apache-2.0
// The verdict on images of a code: what they are lit by and how far their light is spread, not where they
// lie.
//
// | check                          | tolerance | origin                                                  |
// |--------------------------------|-----------|---------------------------------------------------------|
// | chi2 of noise as stated        | 0.05      | 2.5 times what the noise is known to, 2 %               |
// | regional chi2 of noise         | 0.15      | 3 sqrt(2/n), n > 800 blocks                             |
// | factor of an image's light     | 4 sigma   | its own standard error                                  |
#include "compare/verdict/explain_code.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "compare/gray/interior_mask.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::explain_code_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

std::optional<CodeVerdict> code_of(SyntheticSides sides) {
  const testing::FittedGray gray(std::move(sides));
  const measure::CameraDecode *real = gray.real_decode(), *simulated = gray.simulated_decode();
  const ImageU8 interior = interior_mask(gray.pair.mask, real, simulated);
  return explain_code(gray.pair, gray.fit, gray.noise(), {*real, *simulated, interior}, {});
}

template <class Change>
void change_codes(SyntheticSides& sides, Change change) {
  const std::vector<PatternSpec> patterns = expand_sequence(sides.twin.fringes);
  for (std::size_t k = 0; k < patterns.size(); ++k)
    if (patterns[k].is_gray()) change(sides.real.images[0].images[k], k);
}

TEST(ExplainCode, NoiseAsItIsIsExplained) {
  const auto code = code_of(testing::make_sides(testing::coded_truth()));
  ASSERT_TRUE(code);
  EXPECT_TRUE(code->row.explained()) << code->row.chi2 << ' ' << code->row.regional_chi2;
  EXPECT_NEAR(code->row.chi2, 1.0, 0.05);
  EXPECT_NEAR(code->row.regional_chi2, 1.0, 0.15);
  EXPECT_GT(code->row.n_regions, 800u);
  EXPECT_EQ(code->row.quantity, "code");
  for (const CodeLight& light : code->lights) EXPECT_NEAR(light.factor, 1.0, 4.0 * light.sigma);
}

// Few electrons and little contrast: the black level that the steps tell is off by as much as a dark region's
// mean.
TEST(ExplainCode, KnowsHowWellTheBlackLevelIsTold) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SidesTruth t = testing::coded_truth();
    t.electrons_per_dn = 2.0;
    t.noise_dn = 2.0;
    t.contrast = 0.4;
    t.seed = seed;
    const auto code = code_of(testing::make_sides(t));
    ASSERT_TRUE(code);
    EXPECT_TRUE(code->row.explained()) << seed << ": " << code->row.chi2 << ' ' << code->row.regional_chi2
                                       << ' ' << code->row.regional_limit;
  }
}

TEST(ExplainCode, EachImageHasItsOwnLight) {
  SyntheticSides sides = testing::make_sides(testing::coded_truth());
  change_codes(sides, [](GrayImage& image, std::size_t k) {
    for (float& dn : image.as_floats()) dn = 60.0F + (k % 2 == 0 ? 0.97F : 1.02F) * (dn - 60.0F);
  });
  const auto code = code_of(std::move(sides));
  ASSERT_TRUE(code);
  EXPECT_TRUE(code->row.explained()) << code->row.chi2 << ' ' << code->row.regional_chi2;
  for (const CodeLight& light : code->lights)
    EXPECT_NEAR(light.factor, light.image % 2 == 0 ? 0.97 : 1.02, 4.0 * light.sigma) << light.image;
}

TEST(ExplainCode, LightThatIsSpreadFurtherIsNotExplained) {
  SyntheticSides sides = testing::make_sides(testing::coded_truth());
  change_codes(sides, [](GrayImage& image, std::size_t) {
    const GrayImage sharp = image;
    for (int y = 0; y < image.height; ++y)
      for (int x = 1; x + 1 < image.width; ++x)
        image.writable(x, y) = 0.9F * sharp(x, y) + 0.05F * (sharp(x - 1, y) + sharp(x + 1, y));
  });
  const auto code = code_of(std::move(sides));
  ASSERT_TRUE(code);
  EXPECT_EQ(code->row.state, "not explained");
  EXPECT_GT(code->row.chi2, 2.0);
}

/// Returns the mean of a pattern over the projector px that a pixel sees, 0.83 of them.
double seen_by_pixel(const Fringes& fringes, const PatternSpec& pattern, double projector_px) {
  constexpr int kPoints = 200;
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i)
    sum += pattern_value(fringes, pattern, projector_px + 0.83 * ((i + 0.5) / kPoints - 0.5));
  return sum / kPoints;
}

/// Sides whose pixels have an area, and whose real fringes lie `moved_px` beside the twin's.
SyntheticSides with_areas(double moved_px) {
  SidesTruth t = testing::coded_truth();
  SyntheticSides sides = testing::make_sides(t);
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, t.noise_dn);
  for (double& px : sides.real.measurement->cameras[0].directions[0].coordinate_px.data) px += moved_px;
  const std::vector<PatternSpec> patterns = expand_sequence(sides.twin.fringes);
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    if (!patterns[k].is_gray()) continue;
    for (int y = 0; y < t.height; ++y)
      for (int x = 0; x < t.width; ++x) {
        if (!testing::is_lit(t, x, y)) continue;
        const double at = sides.simulated.measurement->cameras[0].directions[0].coordinate_px(x, y);
        const auto light = [&](double px) {
          return testing::weight_at(t, x, y) * seen_by_pixel(sides.twin.fringes, patterns[k], px);
        };
        sides.simulated.irradiance[0].images[k].writable(x, y) = static_cast<float>(light(at));
        sides.real.images[0].images[k].writable(x, y) = static_cast<float>(
            std::round(t.gain_dn * light(at + moved_px) + t.black_level_dn + noise(random)));
      }
  }
  return sides;
}

TEST(ExplainCode, EdgesThatLieElsewhereAreLeftToTheVerdictOnThePhase) {
  for (const double moved_px : {0.0, 0.05, -0.2}) {
    const auto code = code_of(with_areas(moved_px));
    ASSERT_TRUE(code);
    EXPECT_TRUE(code->row.explained()) << moved_px << ' ' << code->row.chi2 << ' ' << code->row.regional_chi2;
  }
  SyntheticSides untold = with_areas(0.05);
  untold.real.measurement->cameras[0].directions[0].coordinate_px =
      untold.simulated.measurement->cameras[0].directions[0].coordinate_px;
  const auto code = code_of(std::move(untold));
  ASSERT_TRUE(code);
  EXPECT_FALSE(code->row.explained()) << code->row.chi2;  // the fringes do not lie there: the code alone does
}

TEST(ExplainCode, WithoutACodeThereIsNothingToSay) {
  SidesTruth t = testing::coded_truth();
  t.gray_bits = 0;
  EXPECT_FALSE(code_of(testing::make_sides(t)));
}

}  // namespace
}  // namespace fringetwin::compare::explain_code_test
