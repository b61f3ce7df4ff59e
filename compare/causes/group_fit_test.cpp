// SPDX-License-Identifier: Apache-2.0
// Groups fitted to gray values that were made by plain numbers: what light does moves no pose, and standard
// errors are those of what really scatters.
//
// | check                          | tolerance | origin                                            |
// |--------------------------------|-----------|---------------------------------------------------|
// | values                         | 4 sigma   | three to nine numbers, one seed: 1 in 1,800       |
// | sigma with nothing to explain  | 10 %      | factor and offset take two of twelve values       |
// | noiseless pose                 | 5e-5 mm   | a last step that lowers chi2 by less than 0.5     |
#include "compare/causes/group_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::group_fit_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 54;
constexpr double kGain = 20.0, kBlack = 7.0, kNoiseDn = 0.5;

Twin window_on_the_sphere() { return testing::window_on_the_sphere(kWidth, kHeight); }

render::Renderer& renderer() { return testing::needed_renderer(); }

using Light = double (*)(int x, int y);
double as_it_is(int, int) { return 1.0; }
/// A projector that is 30 % brighter in the middle.
double hot_spot(int x, int y) {
  const double u = (x - 27.0) / 17.0, v = (y - 20.0) / 17.0;
  return 1.0 + 0.3 * std::exp(-0.5 * (u * u + v * v));
}

/// What the cameras of `truths` recorded, image k from truth k where there are several: kGain E light +
/// kBlack and noise of kNoiseDn.
std::vector<GridSamples> measured(const std::vector<Twin>& truths, Light light = as_it_is,
                                  double noise_dn = kNoiseDn) {
  std::vector<GridSamples> all;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, noise_dn);
  for (std::size_t camera = 0; camera < truths[0].cameras.size(); ++camera) {
    GridSamples s;
    s.camera = camera;
    s.grid = {1, 0, 0, kWidth, kHeight};
    std::vector<std::vector<ImageF>> images;
    for (const Twin& truth : truths) images.push_back(render_grid(renderer(), truth, camera, s.grid, 9));
    for (int k = 0; k < static_cast<int>(images[0].size()); ++k) s.images.push_back(k);
    for (std::size_t i = 0; i < images[0][0].size(); ++i) {
      s.cell.push_back(i);
      const double factor = light(static_cast<int>(i) % kWidth, static_cast<int>(i) / kWidth);
      for (std::size_t k = 0; k < s.images.size(); ++k) {
        const auto e = static_cast<double>(images[truths.size() > 1 ? k : 0][k].data[i]);
        s.real_dn.push_back(static_cast<float>(kGain * factor * e + kBlack + noise(random)));
        s.weight.push_back(static_cast<float>(1.0 / kNoiseDn));
      }
    }
    s.gain_dn = kGain;
    s.black_level_dn = kBlack;
    all.push_back(std::move(s));
  }
  return all;
}

/// Returns by how many standard errors the worst of the told parameters is beside the twin's own value.
double worst_z(const GroupFit& fit) {
  double worst = 0.0;
  for (std::size_t k = 0; k < fit.parameters().size(); ++k)
    if (const GroupFit::Known& known = fit.known()[k]; known.told)
      worst = std::max(worst, std::abs(known.value - fit.parameters()[k].start) / known.sigma);
  return worst;
}

TEST(GroupFit, ConvergesToTheTruthFromFarther) {
  const Twin twin = window_on_the_sphere();
  Twin truth = twin;
  std::get<SphereShape>(truth.objects[0].shape).center_mm += Eigen::Vector3d(0.03, -0.02, 0.04);
  Sensitivity sensitivity(renderer(), measured({truth}, as_it_is, 0.0));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "pose"));
  fit.run();
  EXPECT_TRUE(fit.converged());
  const Eigen::Vector3d found = std::get<SphereShape>(fit.twin().objects[0].shape).center_mm;
  EXPECT_LE((found - std::get<SphereShape>(truth.objects[0].shape).center_mm).norm(), 5e-5);
}

// A fit that runs again counts with the outliers as they are then, not with its last sums.
TEST(GroupFit, CountsAnewWhereTheScaleIsAnother) {
  const Twin twin = window_on_the_sphere();
  Sensitivity sensitivity(renderer(), measured({twin}));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "pose"), {.keep_scale = true});
  fit.run();
  const double before = fit.known()[0].noise_sigma;
  sensitivity.set_scale(std::vector<double>(sensitivity.samples().size(), 0.3));
  fit.run();
  GroupFit anew(sensitivity, twin, parameters_of(twin, "pose"), {.keep_scale = true});
  anew.run();
  EXPECT_GT(fit.known()[0].noise_sigma, 1.2 * before);
  EXPECT_NEAR(fit.known()[0].noise_sigma / anew.known()[0].noise_sigma, 1.0, 1e-3);
}

// Every third pixel of one side is 12 standard deviations too bright: the fit must rest where Huber's loss is
// least. The squares with their robust weights, by which it went before, are least elsewhere.
TEST(GroupFit, RestsWhereTheLossIsLeast) {
  const Twin twin = window_on_the_sphere();
  std::vector<GridSamples> samples = measured({twin});
  const std::size_t n = samples[0].images.size();
  for (std::size_t p = 0; p < samples[0].n_pixels(); p += 3)
    if (static_cast<int>(samples[0].cell[p]) % samples[0].grid.width > samples[0].grid.width / 2)
      for (std::size_t i = p * n; i < (p + 1) * n; ++i) samples[0].real_dn[i] += 12.0F / samples[0].weight[i];
  Sensitivity sensitivity(renderer(), std::move(samples));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "vignetting"), {.exact = true});
  fit.run();
  fit.settle_sensors();
  EXPECT_TRUE(fit.converged());
  const std::vector<Parameter>& parameters = fit.parameters();
  const Sensitivity::Values base = sensitivity.predicted(twin, parameters, fit.values());
  const NormalEquations e = sensitivity.equations_at(
      base, sensitivity.columns(twin, parameters, fit.values(), Sensitivity::Derivative::exact),
      FreePerPixel::nothing);
  std::vector<std::size_t> unknowns;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (fit.known()[k].told) unknowns.push_back(k);
  for (std::size_t c = 0; c < sensitivity.samples().size(); ++c) {
    unknowns.push_back(e.gain_at(c));
    unknowns.push_back(e.black_at(c));
  }
  const Step step = solve_step(e, unknowns);
  EXPECT_GE(unknowns.size(), 4u);
  for (const std::size_t k : unknowns)
    EXPECT_LT(std::abs(step.change[static_cast<Eigen::Index>(k)]),
              0.1 * step.sigma[static_cast<Eigen::Index>(k)]);
}

TEST(GroupFit, LightMovesNoPose) {
  const Twin twin = window_on_the_sphere();
  for (const Light light : {as_it_is, hot_spot}) {
    Sensitivity sensitivity(renderer(), measured({twin}, light));
    GroupFit fit(sensitivity, twin, parameters_of(twin, "pose"));
    fit.run();
    EXPECT_TRUE(fit.converged());
    EXPECT_LT(worst_z(fit), 4.0);
    EXPECT_NEAR(fit.chi2(), 1.0, 0.05);  // the factor of a pixel is no misfit
    GroupFit plain(sensitivity, twin, parameters_of(twin, "pose"), {.free = FreePerPixel::nothing});
    plain.run();
    for (std::size_t k = 0; k < 3; ++k) {
      RecordProperty("sigma_" + std::to_string(k), std::to_string(fit.known()[k].sigma));
      if (light == as_it_is) {
        EXPECT_NEAR(fit.known()[k].sigma / plain.known()[k].sigma, 1.0, 0.1);
      }
    }
    if (light == hot_spot) {
      EXPECT_GT((plain.values() - start_values(plain.parameters())).norm(), 10.0 * fit.known()[2].sigma);
    }
  }
}

TEST(GroupFit, ImagesThatMoveScatterThePose) {
  const Twin twin = window_on_the_sphere();
  std::vector<Twin> truths;
  std::mt19937 random(11);
  std::normal_distribution<double> shift_px(0.0, 0.1);
  for (int k = 0; k < 12; ++k) {
    truths.push_back(twin);
    const double moved_px = shift_px(random);
    for (double& origin_px : truths.back().fringes.directions[0].phase_origin_px) origin_px += moved_px;
  }
  Sensitivity sensitivity(renderer(), measured(truths));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "pose"));
  fit.run();
  EXPECT_LT(worst_z(fit), 4.0);
  double noise_z = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    noise_z = std::max(
        noise_z, std::abs(fit.known()[k].value - fit.parameters()[k].start) / fit.known()[k].noise_sigma);
  EXPECT_GT(noise_z, 5.0);
}

TEST(GroupFit, WhatTheImagesDoNotTellStays) {
  // a projector without distortion that slides along its fringes shows the same, but for a little shading
  Twin twin = window_on_the_sphere();
  const Lens lens = twin.projector->lens;
  const std::vector<double>& k = lens.intrinsics();
  twin.projector->lens =
      Lens("LENSMODEL_PINHOLE", {k[0], k[1], k[2], k[3]}, {lens.width(), lens.height()}, "a pinhole");
  std::vector<Parameter> shifts;
  for (Parameter& p : parameters_of(twin, "rig"))
    if (p.name == "projector.shift_mm.x" || p.name == "projector.shift_mm.y") shifts.push_back(std::move(p));
  ASSERT_EQ(shifts.size(), 2u);
  Twin truth = twin;
  truth.projector->T_proj_world.translation_mm.x() += 0.02;
  truth.projector->T_proj_world.translation_mm.y() += 2.0;
  Sensitivity sensitivity(renderer(), measured({truth}));
  GroupFit fit(sensitivity, twin, shifts, {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_TRUE(fit.known()[0].told);
  EXPECT_LT(std::abs(fit.values()[0] - 0.02), 4.0 * fit.known()[0].sigma);
  EXPECT_FALSE(fit.known()[1].told);
  EXPECT_EQ(fit.values()[1], 0.0);
}

TEST(GroupFit, OneReflectivityIsHeldWhereTheGainIsFree) {
  const SphereShape ball = testing::physical_sphere();
  const Twin both = testing::with_object(testing::with_object(testing::paper_rig(), "ball", ball, {}), "wall",
                                         testing::frontal_plane(300.0), {});
  const Twin truth =
      testing::crop_around(both, ball.center_mm + Eigen::Vector3d(ball.radius_mm, 0.0, 0.0), kWidth, kHeight);
  Twin twin = truth;
  twin.objects[0].material.diffuse *= 0.98;
  Sensitivity sensitivity(renderer(), measured({truth}));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "albedo"), {.free = FreePerPixel::nothing});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.05);
  EXPECT_NE(fit.known()[0].told, fit.known()[1].told);
  const double ratio = fit.values()[0] / fit.values()[1];
  EXPECT_NEAR(ratio, truth.objects[0].material.diffuse / truth.objects[1].material.diffuse, 1e-3);
}

TEST(GroupFit, LightAndPlaceAreFittedInTurn) {
  const Twin twin = window_on_the_sphere();
  Twin truth = twin;
  truth.projector->response.kind = ProjectorResponse::Kind::gamma;
  truth.projector->response.gamma = 1.15;
  std::get<SphereShape>(truth.objects[0].shape).center_mm.z() += 0.05;
  Sensitivity sensitivity(renderer(), measured({truth}));
  std::vector<Parameter> both = parameters_of(twin, "pose");
  both.push_back(parameters_of(twin, "response").at(0));
  GroupFit fit(sensitivity, twin, both);
  fit.run();
  EXPECT_TRUE(fit.converged());
  const Eigen::Vector3d ball = testing::physical_sphere().center_mm;
  const std::vector<double> true_values{ball.x(), ball.y(), ball.z() + 0.05, 1.15};
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_LT(std::abs(fit.values()[k] - true_values[k]), 4.0 * fit.known()[k].sigma)
        << both[k].name << ' ' << fit.values()[k];
  EXPECT_LT(fit.known()[3].sigma, 0.01);
  EXPECT_NEAR(fit.chi2_of_all(), 1.0, 0.05);
}

TEST(GroupFit, FringesHalfAPeriodBesideAreNoNegativeLight) {
  Twin truth = window_on_the_sphere();
  truth.fringes.directions[0].pitches_px = {13.0};
  truth.fringes.directions[0].phase_origin_px = {0.0};
  Twin beside = truth;
  beside.fringes.directions[0].phase_origin_px = {6.5};
  Sensitivity sensitivity(renderer(), measured({truth}));
  EXPECT_NEAR(GroupFit(sensitivity, truth, {}).chi2_with(FreePerPixel::factor_and_offset), 1.0, 0.05);
  EXPECT_GT(GroupFit(sensitivity, beside, {}).chi2_with(FreePerPixel::factor_and_offset), 100.0);
}

TEST(GroupFit, GroupsThatDoTheSameAreToldSo) {
  const Twin twin = window_on_the_sphere();
  Sensitivity sensitivity(renderer(), measured({twin}));
  std::vector<Parameter> both = parameters_of(twin, "pose");
  for (Parameter& p : parameters_of(twin, "rig")) both.push_back(std::move(p));
  EXPECT_THAT(GroupFit(sensitivity, twin, both).cannot_be_told(),
              AllOf(HasSubstr("pose and rig change the gray values alike"), HasSubstr("ball.center_mm."),
                    HasSubstr("projector.")));
  std::vector<Parameter> apart = parameters_of(twin, "pose");
  for (Parameter& p : parameters_of(twin, "blur")) apart.push_back(std::move(p));
  EXPECT_EQ(GroupFit(sensitivity, twin, apart).cannot_be_told(), "");
}

}  // namespace
}  // namespace fringetwin::compare::group_fit_test
