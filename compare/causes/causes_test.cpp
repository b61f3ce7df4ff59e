// SPDX-License-Identifier: Apache-2.0
// Gray values of planted rigs: the cause is named, and gain and black level come with it where it explains
// them.
//
// | check                  | tolerance | origin                                         |
// |------------------------|-----------|------------------------------------------------|
// | gain, black level      | 4 sigma   | two numbers, normal: one seed in 8,000         |
// | blur                   | 1 %       | far beyond its sigma of 0.1 %                   |
// | harmonics              | 4 sigma   | ten numbers, normal: one seed in 1,600           |
// | pose, blur, gamma      | 4 sigma   | normal: one seed in 5,000                       |
// | chi2 with a radius     | 1.15      | the limit of single values: 3 sigma of 5 %      |
#include "compare/causes/causes.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <tuple>

#include "compare/causes/cause_fit.hpp"
#include "compare/geometry/fit_rows.hpp"
#include "compare/parameters/parameters.hpp"
#include "measure/fit/object_fits.hpp"
#include "render/reference/reference.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::causes_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kWidth = 96, kHeight = 80;
constexpr double kGain = 20.0, kBlack = 7.0, kNoiseDn = 0.5, kBlurPx = 2.0, kRadiusError = 0.1,
                 kSmallError = 0.006;

Twin window_on_the_sphere() { return testing::window_on_the_sphere(kWidth, kHeight); }

render::Renderer& renderer() { return testing::needed_renderer(); }

/// Returns what the second camera saw of these images through a sensor of kGain and kBlack, image 3 brighter
/// by `flicker`; gain and black level begin elsewhere. `steps`: the phase steps that are compared; empty:
/// all.
Sensitivity seen(const std::vector<ImageF>& images, double flicker = 0.0,
                 const std::vector<int>& steps = {}) {
  GridSamples s;
  s.camera = 1;
  s.grid = {1, 0, 0, kWidth, kHeight};
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, kNoiseDn);
  for (int k = 0; k < static_cast<int>(images.size()); ++k)
    if (steps.empty() || std::ranges::find(steps, k % 4) != steps.end()) s.images.push_back(k);
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    s.cell.push_back(i);
    for (const int k : s.images) {
      const double bright = k == 3 ? 1.0 + flicker : 1.0;
      s.real_dn.push_back(static_cast<float>(kGain * bright * static_cast<double>(images[k].data[i]) +
                                             kBlack + noise(random)));
      s.weight.push_back(static_cast<float>(1.0 / kNoiseDn));
    }
  }
  s.gain_dn = 0.8 * kGain;
  s.black_level_dn = kBlack + 10.0;
  return {renderer(), {std::move(s)}};
}

Sensitivity seen(const Twin& truth, double flicker = 0.0) {
  return seen(render_grid(renderer(), truth, 1, {1, 0, 0, kWidth, kHeight}, 9), flicker);
}

Causes causes_of(const Twin& truth, double flicker = 0.0) {
  Sensitivity sensitivity = seen(truth, flicker);
  return find_causes(sensitivity, window_on_the_sphere());
}

Twin blurred() {
  Twin truth = window_on_the_sphere();
  truth.projector->blur_px = kBlurPx;
  return truth;
}

SphereShape& ball_of(Twin& twin) { return std::get<SphereShape>(twin.objects[0].shape); }

const CauseRow& row_of(const Causes& causes, const std::string& group) {
  return *std::ranges::find(causes.rows, group, &CauseRow::group);
}
const CauseRegion& region_of(const CauseRow& row, const std::string& kind) {
  return *std::ranges::find(row.regions_after, kind, &CauseRegion::kind);
}

/// Returns what was found, a line per group, for messages.
std::string told(const Causes& causes) {
  std::string text = sentence(causes) + "\n" + ::testing::PrintToString(causes.together) + "\n";
  for (const CauseRow& row : causes.rows) {
    text += fmt::format("{} {}: alone {:.3g}, chi2 {:.4g}", row.order, row.group, row.alone, row.chi2_after);
    for (const CauseRegion& r : row.regions_after)
      text += fmt::format(", {} {:.3g} ({:.3g})", r.kind, r.chi2, r.limit);
    text += "\n";
  }
  return text;
}

TEST(Causes, GainAndBlackLevelAreThoseThatGoWithTheBlur) {
  const Causes causes = causes_of(blurred());
  ASSERT_EQ(causes.named, "blur");
  EXPECT_NEAR(causes.rows[0].parameters.at(0).estimate, kBlurPx, 0.01 * kBlurPx);
  ASSERT_EQ(causes.gain.size(), 1u) << causes.why;
  const CauseGain& gain = causes.gain[0];
  EXPECT_EQ(gain.camera, "right");
  EXPECT_NEAR(gain.gain_dn, kGain, 4.0 * gain.gain_sigma_dn);
  EXPECT_NEAR(gain.black_level_dn, kBlack, 4.0 * gain.black_level_sigma_dn);
  EXPECT_GT(gain.gain_sigma_dn, 0.0);
  EXPECT_LT(gain.gain_sigma_dn, 0.01 * kGain);
  EXPECT_THAT(gain_sentence(causes), HasSubstr("with blur "));
  EXPECT_THAT(gain_sentence(causes), HasSubstr("px; right: gain "));
}

TEST(Causes, ALampThatFlickersIsNamedBesideTheBlur) {
  const Causes causes = causes_of(blurred(), 0.05);
  EXPECT_THAT(causes.together, Contains("blur + light")) << told(causes);
  const CauseRow& blur = row_of(causes, "blur");
  EXPECT_FALSE(blur.passes);
  EXPECT_GT(region_of(blur, "image").chi2, region_of(blur, "image").limit);
}

TEST(Causes, WhatLeavesADifferenceIsNotNamed) {
  Sensitivity sensitivity = seen(blurred());
  std::vector<GridSamples> samples = sensitivity.samples();
  for (std::size_t i = 0; i < samples[0].real_dn.size(); ++i)  // in no group: one value high, one low
    samples[0].real_dn[i] += (i / 7) % 2 == 0 ? 2.0F : -2.0F;
  Sensitivity scattered(renderer(), std::move(samples));
  const Causes causes = find_causes(scattered, window_on_the_sphere());
  EXPECT_THAT(causes.named, IsEmpty());
  EXPECT_THAT(causes.together, IsEmpty());
  EXPECT_THAT(causes.gain, IsEmpty());
  EXPECT_THAT(gain_sentence(causes), IsEmpty());
  EXPECT_THAT(sentence(causes), HasSubstr("none of the causes tested explains"));
}

// 1 % of full scale in quadrature, in the double-precision reference's images.
TEST(Causes, AHarmonicInQuadratureIsNamedWithItsValue) {
  Twin twin = window_on_the_sphere();
  twin.fringes.steps = 8;
  Twin truth = twin;
  truth.fringes.directions[0].harmonics.assign(truth.fringes.directions[0].pitches_px.size(), {{0.0, 0.01}});
  const render::Reference reference(truth);
  std::vector<ImageF> images(expand_sequence(truth.fringes).size(), ImageF(kWidth, kHeight, 0.0F));
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const auto pixel = reference.pixel(1, i % kWidth, i / kWidth, {.gauss_n = 3});
    for (std::size_t k = 0; k < images.size(); ++k)
      images[k].data[static_cast<std::size_t>(i)] = static_cast<float>(pixel.irradiance[k]);
  }
  Sensitivity sensitivity = seen(images);
  const Causes causes = find_causes(sensitivity, twin);
  EXPECT_THAT(causes.together, Contains("harmonics")) << told(causes);
  for (const CauseParameter& p : row_of(causes, "harmonics").parameters) {
    const double planted = p.name == "projector.harmonic.2.quadrature" ? 0.01 : 0.0;
    EXPECT_NEAR(p.estimate, planted, 4.0 * p.sigma) << p.name;
    EXPECT_LT(p.sigma, 1e-3) << p.name;
  }
}

TEST(Causes, APoseIsNamedWithItsValue) {
  Twin truth = window_on_the_sphere();
  ball_of(truth).center_mm.z() += 0.02;
  const Causes causes = causes_of(truth);
  EXPECT_THAT(causes.together, Contains("pose")) << told(causes);
  EXPECT_TRUE(row_of(causes, "pose").passes);
  const CauseParameter& z = row_of(causes, "pose").parameters.at(2);
  ASSERT_EQ(z.name, "ball.center_mm.z");
  EXPECT_NEAR(z.estimate - z.twin, 0.02, 4.0 * z.sigma);
}

TEST(Causes, ARadiusIsNoPose) {
  Twin truth = window_on_the_sphere();
  ball_of(truth).radius_mm += kRadiusError;
  const Causes causes = causes_of(truth);
  EXPECT_THAT(causes.together, Contains("size")) << told(causes);
  EXPECT_THAT(causes.together, Not(Contains("pose"))) << told(causes);
  EXPECT_GT(row_of(causes, "pose").alone, 0.99) << told(causes);
  // single values pass: only the places of the fringes, summed up, tell
  Sensitivity sensitivity = seen(truth);
  const Twin twin = window_on_the_sphere();
  const CauseFit fit = fit_cause(sensitivity, twin, parameters_of(twin, "pose"), FreePerPixel::nothing);
  EXPECT_LT(fit.chi2, 1.15);
  const CauseRegion& shift = fit.regions.at(2);
  ASSERT_EQ(shift.kind, "shift");
  EXPECT_GT(shift.chi2, 2.0 * shift.limit);
}

// Light of a lamp beside, an offset of each pixel, and shot noise: what noise the values have is known only
// with the gain that goes with the offset, whatever it was before. At 0.4 times the gain the dark values
// would be given too much noise and the bright ones too little.
TEST(Causes, AnOffsetOfEachPixelHasTheNoiseOfItsOwnGain) {
  constexpr double kPerDn = 0.2;
  const Twin twin = window_on_the_sphere();
  GridSamples s = seen(twin).samples()[0];
  s.noise_dn2 = [](double dn) { return 0.1 + kPerDn * std::max(0.0, dn - kBlack); };
  const Sensitivity as_seen(renderer(), {s});
  const Sensitivity::Values predicted = as_seen.predicted(twin, {}, {});
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (std::size_t i = 0; i < s.real_dn.size(); ++i) {
    const double lamp_dn = 20.0 + 15.0 * std::sin(0.001 * static_cast<double>(i / s.images.size())),
                 dn = kBlack + lamp_dn + kGain * static_cast<double>(predicted[0][i]);
    s.real_dn[i] = static_cast<float>(dn + std::sqrt(s.noise_dn2(dn)) * normal(random));
  }
  s.gain_dn = 0.4 * kGain;
  const Sensitivity sensitivity(renderer(), {s});
  const CauseFit fit = fit_cause(sensitivity, twin, {}, FreePerPixel::offset, {.predicted = predicted});
  // of 84,000 values 1 +- 0.005; the noise of a level that is known to 5 % makes 0.01 more of it
  EXPECT_NEAR(fit.chi2, 1.0, 0.02);
  EXPECT_NEAR(fit.gain.at(0).gain_dn, kGain, 4.0 * fit.gain.at(0).gain_sigma_dn);
}

/// The fits of the ball on both sides, of the twin's and of the true one, known to 1 um.
std::vector<FitRow> fits_of(const Twin& twin, const Twin& truth) {
  std::vector<measure::ObjectFit> sides;
  for (const Twin* side : {&twin, &truth}) {
    sides.push_back(measure::nominal_fit(side->objects[0]).value());
    sides.back().numbers["radius_sigma_mm"] = 0.001;
    sides.back().vectors["center_sigma_mm"] = Eigen::Vector3d::Constant(0.001);
  }
  return {make_fit_row(sides[0], sides[1])};
}

// A window on the middle of the ball does not tell a larger one from a nearer one, but the fits do.
TEST(Causes, FitsOfTheObjectsTellWhatGrayValuesDoNot) {
  const Twin twin = window_on_the_sphere();
  Twin larger = twin, nearer = twin;
  ball_of(larger).radius_mm += kSmallError;
  ball_of(nearer).center_mm.z() -= kSmallError;
  const Causes alike = causes_of(larger);
  EXPECT_THAT(alike.together, Contains("pose")) << told(alike);
  EXPECT_TRUE(std::isnan(row_of(alike, "pose").fit_z_after));
  for (const auto& [truth, right, wrong] : {std::tuple{larger, "size", "pose"}, {nearer, "pose", "size"}}) {
    Sensitivity sensitivity = seen(truth);
    const Causes causes = find_causes(sensitivity, twin, fits_of(twin, truth));
    EXPECT_THAT(causes.together, Contains(right)) << told(causes);
    EXPECT_THAT(causes.together, Not(Contains(wrong))) << told(causes);
    EXPECT_LT(row_of(causes, right).fit_z_after, 3.0) << told(causes);
  }
}

TEST(Causes, TwoAreNamedTogetherWhereNoneExplainsAll) {
  Twin truth = blurred();
  truth.projector->response = {ProjectorResponse::Kind::gamma, 1.2, {}};
  const Causes causes = causes_of(truth);
  ASSERT_THAT(causes.together, Contains("blur + response")) << told(causes);
  EXPECT_FALSE(row_of(causes, "blur").passes || row_of(causes, "response").passes);
  const CauseParameter &blur = row_of(causes, "blur").parameters.at(0),
                       &gamma = row_of(causes, "response").parameters.at(0);
  EXPECT_NEAR(blur.estimate, kBlurPx, 4.0 * blur.sigma);
  EXPECT_NEAR(gamma.estimate, 1.2, 4.0 * gamma.sigma);
}

TEST(Causes, NoGainIsOfferedWithWhatIsOne) {
  Twin truth = window_on_the_sphere();
  truth.cameras[1].vignetting = {Vignetting::Kind::polynomial, {}, {0.2, 0.0}};
  const Causes causes = causes_of(truth);
  EXPECT_THAT(causes.together, Contains("vignetting")) << told(causes);
  EXPECT_THAT(causes.together, Contains("texture")) << told(causes);  // one camera: it may be on the ball
  EXPECT_THAT(causes.gain, IsEmpty());
  EXPECT_THAT(causes.why, HasSubstr("cannot be told from it"));
}

TEST(ValuesOfFits, MoveTheObjectThatHasAFitAndLeaveTheOthers) {
  constexpr double kSigmaMm = 0.001;
  Twin twin = window_on_the_sphere(), truth = twin;
  const auto fit_of = [&](const Twin& of) {
    measure::ObjectFit fit = measure::nominal_fit(of.objects[0]).value();
    fit.numbers["radius_sigma_mm"] = kSigmaMm;
    fit.vectors["center_sigma_mm"] = Eigen::Vector3d::Constant(kSigmaMm);
    return fit;
  };
  ball_of(truth).center_mm.x() += 0.1;
  // nothing was measured of the wall: what moves it changes no z
  twin.objects.push_back(
      {"wall", PlaneShape{{0, 0, 300}, -Eigen::Vector3d::UnitZ(), {}, Eigen::Vector3d::UnitX()}, {}});
  const std::vector<FitRow> apart{make_fit_row(fit_of(twin), fit_of(truth))},
      alike{make_fit_row(fit_of(twin), fit_of(twin))};
  const std::vector<Parameter> pose = parameters_of(twin, "pose");
  ASSERT_GT(pose.size(), 3u);
  const std::optional<Eigen::VectorXd> values = values_of_fits(apart, twin, pose);
  ASSERT_TRUE(values.has_value());
  Twin moved = twin;
  for (std::size_t k = 0; k < pose.size(); ++k)
    pose[k].change(moved, (*values)[static_cast<Eigen::Index>(k)] - pose[k].start);
  // Gauss-Newton on numbers that are linear in the place: rounding
  EXPECT_NEAR((ball_of(moved).center_mm - ball_of(truth).center_mm).norm(), 0.0, 1e-6);
  const auto &wall = std::get<PlaneShape>(twin.objects[1].shape),
             &still = std::get<PlaneShape>(moved.objects[1].shape);
  EXPECT_EQ(still.point_mm, wall.point_mm);
  EXPECT_EQ(still.normal, wall.normal);
  EXPECT_FALSE(values_of_fits(alike, twin, pose).has_value());
}

TEST(Causes, WhereNothingIsNamedNothingIsSaid) { EXPECT_EQ(gain_sentence({}), ""); }

// Of some steps only, the factors are one in the mean of those, whichever the first is.
TEST(Causes, LightOfTheStepsThatAreCompared) {
  constexpr double kFlicker = 0.05;
  const Twin twin = window_on_the_sphere();
  const std::vector<int> steps{1, 3};
  Sensitivity sensitivity =
      seen(render_grid(renderer(), twin, 1, {1, 0, 0, kWidth, kHeight}, 9), kFlicker, steps);
  const Causes causes = find_causes(sensitivity, twin, {}, steps);
  const auto light = std::ranges::find(causes.rows, "light", &CauseRow::group);
  ASSERT_NE(light, causes.rows.end());
  ASSERT_EQ(light->parameters.size(), 5u);  // of six images
  const double mean = std::log(1.0 + kFlicker) / 6.0;
  for (const CauseParameter& p : light->parameters)
    EXPECT_NEAR(p.estimate, (p.name == "image_3.light" ? std::log(1.0 + kFlicker) : 0.0) - mean,
                4.0 * p.sigma)
        << p.name;
}

}  // namespace
}  // namespace fringetwin::compare::causes_test
