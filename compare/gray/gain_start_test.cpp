// SPDX-License-Identifier: Apache-2.0
// Truth: synthetic images with known gain and black level, whose fringes the twin puts elsewhere or whose
// reflectivity it does not know (tests/support/compare/synthetic_sides.hpp).
//
// | check                         | tolerance       | origin |
// |-------------------------------|-----------------|--------------------------------------------------------|
// | line of the amplitudes, right | 0.3 %, 0.3 DN   | 1.5 DN of noise on 12 values of 60 DN, 20,000 pixels |
// | the same, phases wrong        | 1 %, 1 DN       | besides: the mean of 12 steps is the same to 0.1 DN |
// | margins from the clips        | 3 DN            | three times 9 DN of noise, estimated to 3 % | | gain
// below a clip             | 3.5 sigma       | reported standard error                                |
#include "compare/gray/gain_start.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/gray/gain_fit.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gain_start_test {
namespace {

using testing::FittedGray;
using testing::gray_pair;
using ::testing::HasSubstr;
using testing::Margins;
using testing::misjudged_truth;
using ::testing::Not;
using testing::SidesTruth;
using testing::SyntheticSides;

/// The irradiance of the image that is `by` steps further: fringes that lie elsewhere.
void shift_steps(SyntheticSides& scene, int steps, int by) {
  std::vector<GrayImage>& e = scene.simulated.irradiance[0].images;
  const std::vector<GrayImage> before = e;
  for (int k = 0; k < static_cast<int>(e.size()); ++k) e[k] = before[k / steps * steps + (k + by) % steps];
}

/// Multiplies the real light at the pixels where `bright` holds, black level apart.
template <class Where>
void scale_real(SyntheticSides& scene, const SidesTruth& t, double factor, Where where) {
  const double max_dn = scene.twin.cameras[0].sensor.max_dn();
  for (GrayImage& image : scene.real.images[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (where(x, y))
          image.writable(x, y) = static_cast<float>(std::clamp(
              std::round(t.black_level_dn + factor * (static_cast<double>(image(x, y)) - t.black_level_dn)),
              0.0, max_dn));
}

std::string last_warning(const FittedGray& f) { return f.warnings.empty() ? "" : f.warnings.back(); }

TEST(GainStart, HoldsTheAmplitudesAndNoPhase) {
  const SidesTruth t;
  SyntheticSides scene = testing::make_sides(t);
  const auto line = [&] { return start_of_amplitudes(gray_pair(scene), nullptr); };
  const auto right = line();
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->gain_dn / t.gain_dn, 1.0, 0.003);
  EXPECT_NEAR(right->black_level_dn, t.black_level_dn, 0.3);
  EXPECT_FALSE(right->scatters());
  for (const int by : {1, 2, 3}) {
    shift_steps(scene, t.steps, 1);
    const auto turned = line();
    ASSERT_TRUE(turned);
    EXPECT_NEAR(turned->gain_dn / t.gain_dn, 1.0, 0.01) << by;
    EXPECT_NEAR(turned->black_level_dn, t.black_level_dn, 1.0) << by;
  }
}

TEST(GainStart, ReflectivityThatVariesIsToldApart) {
  const SidesTruth t;
  SyntheticSides scene = testing::make_sides(t);
  scale_real(scene, t, 0.35, [](int x, int y) { return (x / 8 + y / 8) % 2 == 0; });
  const auto line = start_of_amplitudes(gray_pair(scene), nullptr);
  ASSERT_TRUE(line);
  EXPECT_TRUE(line->scatters());
  EXPECT_NEAR(line->black_level_dn, t.black_level_dn, 0.3);  // each pixel with its own factor
}

TEST(GainStart, ConstantLightTellsNothing) {
  SyntheticSides scene = testing::make_sides({});
  for (GrayImage& image : scene.simulated.irradiance[0].images) std::ranges::fill(image.as_floats(), 5.0F);
  EXPECT_FALSE(start_of_amplitudes(gray_pair(scene), nullptr));
}

TEST(GainStart, FringesElsewhereLeaveAProvisionalLineAndNoGain) {
  const SidesTruth t = misjudged_truth();
  for (const int by : {1, 2}) {  // a quarter and half a period: residuals of 1,000 DN and more
    SyntheticSides scene = testing::make_sides(t);
    shift_steps(scene, t.steps, by);
    const FittedGray f(scene, Margins::noise);
    EXPECT_FALSE(f.fit.row.usable);
    ASSERT_TRUE(f.fit.has_line());
    EXPECT_NEAR(f.fit.row.gain_dn / t.gain_dn, 1.0, 0.01);
    EXPECT_NEAR(f.fit.row.black_level_dn, t.black_level_dn, 10.0);
    EXPECT_GT(f.fit.row.n, 150'000u);  // 20,000 pixels, 12 images
    EXPECT_THAT(last_warning(f), HasSubstr("they do not lie where the twin puts them"));
    const GainRow row = published_row(f.fit);
    EXPECT_TRUE(std::isnan(row.gain_dn) && std::isnan(row.black_level_dn) && std::isnan(row.r2));
    EXPECT_EQ(row.provisional_gain_dn, f.fit.row.gain_dn);
    EXPECT_THAT(row.why, HasSubstr("they do not lie where the twin puts them"));
    EXPECT_EQ(fit_of(f.pair, row).row.gain_dn, f.fit.row.gain_dn);
  }
}

TEST(GainStart, ADarkBoardWithBrightCirclesHasNoGain) {
  const SidesTruth t = misjudged_truth();
  SyntheticSides scene = testing::make_sides(t);
  scale_real(scene, t, 0.05, [](int x, int y) {
    const int u = x % 16 - 8, v = y % 16 - 8;
    return u * u + v * v > 16;
  });
  const FittedGray f(scene, Margins::noise);
  EXPECT_FALSE(f.fit.row.usable);
  EXPECT_THAT(last_warning(f), HasSubstr("reflectivity"));
  EXPECT_TRUE(f.fit.has_line());
}

TEST(GainStart, ACameraWithoutAGainKeepsItsRowsAndIsNotExplained) {
  const SidesTruth t = misjudged_truth();
  SyntheticSides scene = testing::make_sides(t);
  shift_steps(scene, t.steps, 1);
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  ASSERT_EQ(c.gain.size(), 1u);
  EXPECT_TRUE(std::isnan(c.gain[0].gain_dn));
  EXPECT_EQ(c.gray.size(), 12u);
  EXPECT_EQ(c.gray_budget.size(), 1u);
  EXPECT_EQ(c.shift.size(), 1u);
  bool judged = false;
  for (const ExplainedRow& row : c.explained)
    if (row.quantity == "gray") {
      judged = true;
      EXPECT_FALSE(row.explained());
    }
  EXPECT_TRUE(judged);
}

TEST(GainStart, AMessageCountsWhatIsThere) {
  SidesTruth t;
  t.black_level_dn = 400.0;  // every value stands at 255
  const FittedGray saturated(testing::make_sides(t), Margins::noise);
  EXPECT_FALSE(saturated.fit.has_line());
  const std::uint64_t n = 12u * static_cast<std::uint64_t>(std::count(saturated.pair.mask.data.begin(),
                                                                      saturated.pair.mask.data.end(), 1));
  EXPECT_THAT(last_warning(saturated), HasSubstr("of " + std::to_string(n) + " gray values"));
  EXPECT_THAT(last_warning(saturated), HasSubstr(" " + std::to_string(n) + " are saturated; 0 are left"));
  SyntheticSides constant = testing::make_sides({});
  for (GrayImage& image : constant.simulated.irradiance[0].images) std::ranges::fill(image.as_floats(), 5.0F);
  const FittedGray flat(constant, Margins::noise);
  EXPECT_THAT(last_warning(flat), HasSubstr("of " + std::to_string(n) + " gray values"));
  EXPECT_THAT(last_warning(flat), HasSubstr("irradiance does not vary"));
  EXPECT_THAT(last_warning(flat), Not(HasSubstr("; 0 are left")));
}

TEST(GainStart, TheMarginsComeFromTheNoiseWhateverTheResidualsAre) {
  SidesTruth t = misjudged_truth();
  const auto margins = [&](double albedo) {
    t.albedo_sigma = albedo;
    const FittedGray f(testing::make_sides(t), Margins::noise);
    EXPECT_TRUE(f.fit.row.usable);
    return std::pair{f.fit.row.low_dn, 4095.0 - f.fit.row.high_dn};
  };
  // 9 DN of noise: 27 DN; the redundancy of the steps tells it to 10 %
  const auto [low, high] = margins(0.0);
  EXPECT_NEAR(low, 27.0, 3.0);
  EXPECT_NEAR(high, 27.0, 3.0);
  const auto [low_textured, high_textured] = margins(0.1);  // residuals of 130 DN
  EXPECT_NEAR(low_textured, low, 3.0);
  EXPECT_NEAR(high_textured, high, 3.0);
}

TEST(GainStart, AClipBelowFullScaleIsLeftOut) {
  SidesTruth t = misjudged_truth();
  SyntheticSides scene = testing::make_sides(t);
  for (GrayImage& image : scene.real.images[0].images)
    for (float& v : image.as_floats()) v = std::min(v, 2600.0F);
  scene.real.images[0].clip = Clip{2600.0, 1};
  const FittedGray f(scene, Margins::noise);
  ASSERT_TRUE(f.fit.row.usable);
  EXPECT_EQ(f.fit.row.clip_dn, 2600.0);
  EXPECT_LT(f.fit.row.high_dn, 2600.0);
  EXPECT_NEAR(f.fit.row.gain_dn, t.gain_dn, 3.5 * f.fit.row.gain_sigma_dn);
}

}  // namespace
}  // namespace fringetwin::compare::gain_start_test
