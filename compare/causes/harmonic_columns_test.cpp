// SPDX-License-Identifier: Apache-2.0
// What harmonics of the fringes bring is told by fringes of their own, as by renderings of the twin with more
// of them, and what shifts and contrasts of single images bring beside them by one rendering; settled at many
// pixels they are nearer to the truth than a fit to few of them leaves them.
//
// | check                   | tolerance | origin                                                    |
// |-------------------------|-----------|-----------------------------------------------------------|
// | derivative, of its rms  | 1e-3      | as Parameter::effect says                                 |
// | settled, rms over sigma | 0.65      | 9 times the pixels: 1/3, and 3 x 1/3 / sqrt(24) for 12     |
#include <gtest/gtest.h>

#include <cmath>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/refine/settled_harmonics.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::harmonic_columns_test {
namespace {

using namespace planted_samples;

render::Renderer& renderer() { return testing::needed_renderer(); }

/// Three pitches each way whose contrasts differ, of a projector that blurs, scatters and flickers, shown
/// through a curve.
Twin rig() {
  Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  twin.fringes.steps = 8;
  DirectionFringes& x = twin.fringes.directions[0];
  x.contrast = {1.0, 0.9, 0.8};
  x.harmonics.assign(3, {{0.004, 0.002}, {0.0, -0.006}});
  DirectionFringes y = x;
  y.axis = Axis::y;
  y.contrast = {};
  twin.fringes.directions.push_back(y);
  Projector& projector = *twin.projector;
  projector.blur_px = 0.8;
  projector.halo = {{0.1, 3.0}};
  projector.response = {ProjectorResponse::Kind::gamma, 1.3, {}};
  const std::size_t n = expand_sequence(twin.fringes).size();
  for (std::size_t k = 0; k < n; ++k) {
    const auto at = static_cast<double>(k);
    projector.light_factors.push_back(1.0 + 0.03 * std::sin(1.3 * at));
    projector.image_shifts_px.push_back(0.4 * std::cos(0.7 * at));
    twin.cameras[0].exposure_factors.push_back(1.0 + 0.02 * std::cos(2.1 * at));
  }
  return twin;
}

using Values = std::vector<Sensitivity::Values>;

/// Expects the derivatives by each of the parameters to be the same but for `part` of their rms.
void expect_alike(const std::vector<Parameter>& parameters, const Values& found, const Values& wanted,
                  double part = 1e-3) {
  for (std::size_t k = 0; k < parameters.size(); ++k)
    for (std::size_t c = 0; c < wanted[k].size(); ++c) {
      double off = 0.0, size = 0.0;
      for (std::size_t i = 0; i < wanted[k][c].size(); ++i) {
        const auto by_twins = static_cast<double>(wanted[k][c][i]);
        off += std::pow(static_cast<double>(found[k][c][i]) - by_twins, 2);
        size += by_twins * by_twins;
      }
      ASSERT_GT(size, 0.0) << parameters[k].name;
      EXPECT_LT(std::sqrt(off / size), part) << parameters[k].name << ' ' << c;
    }
}

TEST(HarmonicColumns, AreWhatTheTwinShowsMore) {
  const Twin twin = rig();
  const Images images = rendered(twin);
  const std::vector<CameraImages> frames = frames_of(images);
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  std::vector<Parameter> told = parameters_of(twin, "harmonics"), shown = told;
  ASSERT_EQ(told.size(), 10u);
  for (Parameter& p : shown) p.effect = nullptr, p.harmonic = 0;
  const Eigen::VectorXd at = start_values(told);
  const auto exact = Sensitivity::Derivative::exact;
  expect_alike(told, sensitivity.columns(twin, told, at, exact, {}).each,
               sensitivity.columns(twin, shown, at, exact, {}).each);
}

// Overtones go k times as far as the fringe, and alias in its own steps: one rendering of all images tells
// what each does, where its own steps are too far off to fit by.
TEST(ImageColumns, AreRenderedTogetherWhereFringesHaveOvertones) {
  Twin twin = rig();
  for (Harmonics& of_pitch : twin.fringes.directions[0].harmonics)
    of_pitch = {{0.004, 0.002}, {0.0, -0.006}, {}, {}, {0.02, -0.01}};
  twin.fringes.image_harmonics.assign(expand_sequence(twin.fringes).size(), {});
  twin.fringes.image_harmonics[3] = {{-0.02, 0.0}, {0.006, -0.003}};
  const Images images = rendered(twin);
  const std::vector<CameraImages> frames = frames_of(images);
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  const auto exact = Sensitivity::Derivative::exact;
  for (const char* group : {"image_shift", "image_harmonics"}) {
    std::vector<Parameter> told = parameters_of(twin, group, {3});
    std::erase_if(told, [](const Parameter& p) { return !p.effect; });
    ASSERT_EQ(told.size(), 6u) << group;
    std::vector<Parameter> shown = told, alone = told;
    for (Parameter& p : shown) p.effect = nullptr, p.does_as = nullptr;
    for (Parameter& p : alone) p.effect_of_sinusoids = false;
    const Eigen::VectorXd at = start_values(told);
    const Values wanted = sensitivity.columns(twin, shown, at, exact, {}).each;
    expect_alike(told, sensitivity.columns(twin, told, at, exact, {}).each, wanted);
    double off = 0.0, size = 0.0;
    const Values by_steps = sensitivity.columns(twin, alone, at, exact, {}).each;
    for (std::size_t i = 0; i < wanted[0][0].size(); ++i) {
      off += std::pow(static_cast<double>(by_steps[0][0][i] - wanted[0][0][i]), 2);
      size += std::pow(static_cast<double>(wanted[0][0][i]), 2);
    }
    EXPECT_GT(std::sqrt(off / size), 5e-3) << group;
    // the search for causes; its quick steps bend
    expect_alike(told, sensitivity.columns_of_all_groups(twin, told, at, {}, [](std::size_t) {}).each, wanted,
                 1e-2);
    // not beside exposures that may be late, and where a free factor takes what all images have in common
    std::vector<Parameter> beside = told;
    beside.push_back(parameters_of(twin, "blur").front());
    beside.back().group = "timing";
    const Eigen::VectorXd with = start_values(beside);
    EXPECT_EQ(sensitivity.columns(twin, beside, with, exact, {}).each[0], by_steps[0]) << group;
    beside.back().group = "camera_response", beside.back().is_of_sensor = true;
    EXPECT_NE(sensitivity.columns(twin, beside, with, exact, {}).each[0], by_steps[0]) << group;
    sensitivity.free_in_all(FreePerPixel::factor_and_offset);
    EXPECT_EQ(sensitivity.columns(twin, beside, with, exact, {}).each[0], by_steps[0]) << group;
    sensitivity.free_in_all(FreePerPixel::nothing);
  }
}

// Where more than fringes is brought, the twin is rendered.
TEST(HarmonicColumns, AreRenderedWhereThingsMove) {
  Twin twin = rig();
  for (const Parameter& p : parameters_of(twin, "harmonics")) EXPECT_TRUE(p.effect);
  twin.objects.front().motion = {0.1, 0.0, 0.0};
  for (const Parameter& p : parameters_of(twin, "harmonics")) EXPECT_FALSE(p.effect);
}

// Exposures that are to be told as late ones let other images in.
TEST(HarmonicColumns, AreRenderedBesideExposuresThatMayBeLate) {
  Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  twin.fringes.steps = 8;
  const Images images = rendered(twin);
  const std::vector<CameraImages> frames = frames_of(images);
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  std::vector<Parameter> parameters{parameters_of(twin, "harmonics").front()};
  sensitivity.columns(twin, parameters, start_values(parameters));
  EXPECT_EQ(sensitivity.samples()[0].highest_harmonic, 2);
  parameters.push_back(parameters.front());
  parameters.back().group = "timing", parameters.back().name = "late", parameters.back().harmonic = 0,
  parameters.back().effect = nullptr;
  sensitivity.columns(twin, parameters, start_values(parameters));
  EXPECT_EQ(sensitivity.samples()[0].highest_harmonic, 1);
}

/// Keeps every ninth pixel.
std::vector<GridSamples> few_of(std::vector<GridSamples> all) {
  for (GridSamples& s : all) {
    GridSamples few = s;
    few.cell.clear(), few.real_dn.clear(), few.weight.clear();
    const auto n = static_cast<std::ptrdiff_t>(s.images.size());
    for (std::ptrdiff_t p = 0; p < std::ssize(s.cell); p += 9) {
      few.cell.push_back(s.cell[static_cast<std::size_t>(p)]);
      few.real_dn.insert(few.real_dn.end(), s.real_dn.begin() + n * p, s.real_dn.begin() + n * (p + 1));
      few.weight.insert(few.weight.end(), s.weight.begin() + n * p, s.weight.begin() + n * (p + 1));
    }
    s = few;
  }
  return all;
}

TEST(SettledHarmonics, AreNearerToTheTruth) {
  Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  twin.fringes.steps = 9;
  Twin truth = twin;
  const Harmonics planted{{0.008, -0.011}, {-0.003, 0.009}, {0.0, 0.005},
                          {0.004, -0.003}, {-0.004, 0.006}, {0.001, 0.002}};
  truth.fringes.directions[0].harmonics.assign(3, planted);
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  const std::vector<GridSamples> samples = samples_of(rendered(truth), same, frames);
  Sensitivity few(renderer(), few_of(samples)), all(renderer(), samples);
  std::vector<Parameter> parameters = parameters_of(twin, "harmonics");
  ASSERT_EQ(parameters.size(), 12u);
  for (Parameter& p : parameters_of(twin, "blur")) parameters.push_back(std::move(p));  // stays as it is
  GroupFit fit(few, twin, parameters, {.exact = true});
  fit.run();
  std::vector<bool> told;
  for (const GroupFit::Known& known : fit.known()) told.push_back(known.told);
  ASSERT_TRUE(can_settle_harmonics(twin, parameters, told));
  all.take_sensors(few.samples());
  const Eigen::VectorXd settled = with_settled_harmonics(all, twin, parameters, told, fit.values(), false);
  double before = 0.0, after = 0.0;
  for (std::size_t k = 0; k < 12; ++k) {
    const double value = k % 2 == 0 ? planted[k / 2].cosine : planted[k / 2].sine,
                 sigma = fit.known()[k].noise_sigma;
    before += std::pow((fit.values()[static_cast<Eigen::Index>(k)] - value) / sigma, 2);
    after += std::pow((settled[static_cast<Eigen::Index>(k)] - value) / sigma, 2);
  }
  EXPECT_LT(std::sqrt(after / before), 0.65);
  EXPECT_LT(std::sqrt(after / 12.0), 0.65);  // 0.33 (1 + 3/sqrt(24)) = 0.54, and the noise of sigma
  for (Eigen::Index k = 12; k < settled.size(); ++k) EXPECT_EQ(settled[k], fit.values()[k]);
  told.assign(told.size(), false);
  EXPECT_FALSE(can_settle_harmonics(twin, parameters, told)) << "nothing is told";
}

}  // namespace
}  // namespace fringetwin::compare::harmonic_columns_test
