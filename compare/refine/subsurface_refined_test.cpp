// SPDX-License-Identifier: Apache-2.0
// Light that goes below a surface, as the reference in double precision sees it: it is named, and found back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "compare/causes/causes.hpp"
#include "compare/causes/group_fit.hpp"
#include "compare/causes/parameters.hpp"
#include "render/reference/reference.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::subsurface_refined_test {
namespace {

using ::testing::ElementsAre;

constexpr int kWidth = 96, kHeight = 80;
constexpr double kGain = 20.0, kBlack = 7.0, kNoiseDn = 0.5;

Twin rig() { return testing::window_on_the_sphere(kWidth, kHeight); }

Twin with_path(double mean_free_path_mm) {
  Twin twin = rig();
  twin.objects[0].material.mean_free_path_mm = mean_free_path_mm;
  return twin;
}

/// What both cameras see of a twin, with noise.
std::vector<GridSamples> seen(const Twin& truth) {
  const render::Reference reference(truth);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, kNoiseDn);
  std::vector<GridSamples> all;
  for (std::size_t c = 0; c < 2; ++c) {
    GridSamples s;
    s.camera = c;
    s.grid = {1, 0, 0, kWidth, kHeight};
    s.gain_dn = kGain;
    s.black_level_dn = kBlack;
    for (const auto& p : testing::reference_block(reference, c, {0, 0, kWidth, kHeight, 1}, {.gauss_n = 2})) {
      s.cell.push_back(static_cast<std::size_t>(p.y * kWidth + p.x));
      for (const double light : p.pixel.irradiance) {
        s.real_dn.push_back(static_cast<float>(kGain * light + kBlack + noise(random)));
        s.weight.push_back(static_cast<float>(1.0 / kNoiseDn));
      }
    }
    for (int k = 0; k < 12; ++k) s.images.push_back(k);
    all.push_back(std::move(s));
  }
  return all;
}

TEST(SubsurfaceRefined, IsNamed) {
  REQUIRE_RENDERER();
  for (const double path_mm : {0.3, 1.0, 3.0}) {
    Sensitivity sensitivity(testing::needed_renderer(), seen(with_path(path_mm)));
    const Causes causes = find_causes(sensitivity, rig());
    EXPECT_THAT(causes.together, ElementsAre("subsurface")) << path_mm;
    const auto row = std::ranges::find(causes.rows, "subsurface", &CauseRow::group);
    ASSERT_NE(row, causes.rows.end());
    ASSERT_EQ(row->parameters.size(), 1u);
    EXPECT_NEAR(row->parameters[0].estimate, path_mm, 3.0 * row->parameters[0].sigma);
  }
}

TEST(SubsurfaceRefined, IsRefinedBackFromNoneAndFromTooMuch) {
  REQUIRE_RENDERER();
  for (const double path_mm : {0.3, 1.0, 3.0})
    for (const double start_mm : {0.0, 2.0}) {
      Sensitivity sensitivity(testing::needed_renderer(), seen(with_path(path_mm)));
      const Twin twin = with_path(start_mm);
      GroupFit fit(sensitivity, twin, parameters_of(twin, "subsurface"), {.exact = true});
      fit.run();
      EXPECT_TRUE(fit.converged());
      EXPECT_NEAR(fit.chi2(), 1.0, 0.02);  // 184,320 values: sqrt(2/n) = 0.0033
      ASSERT_EQ(fit.known().size(), 1u);
      EXPECT_NEAR(fit.known()[0].value, path_mm, 3.0 * fit.known()[0].sigma) << start_mm;
      EXPECT_LT(fit.known()[0].sigma, 0.02 * path_mm);
      EXPECT_NEAR(fit.twin().objects[0].material.mean_free_path_mm, fit.known()[0].value, 1e-9);
    }
}

// Camera and projector look from one place: no fringe moves, and contrast falls with the square of a short
// path.
TEST(SubsurfaceRefined, IsFoundFromItsContrastAlone) {
  REQUIRE_RENDERER();
  const auto coaxial = [](double path_mm) {
    Twin twin = with_path(path_mm);
    const Pose& T = twin.cameras[0].T_cam_world;
    twin.projector->T_proj_world = twin.cameras[1].T_cam_world = T;
    twin.cameras[1].lens = twin.cameras[0].lens;
    return twin;
  };
  Sensitivity sensitivity(testing::needed_renderer(), seen(coaxial(0.5)));
  const Twin twin = coaxial(0.0);
  GroupFit fit(sensitivity, twin, parameters_of(twin, "subsurface"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);
  ASSERT_EQ(fit.known().size(), 1u);
  EXPECT_NEAR(fit.known()[0].value, 0.5, 3.0 * fit.known()[0].sigma);
}

TEST(SubsurfaceRefined, IsNoneOfAProjectorWhoseDefocusIsRendered) {
  Twin twin = rig();
  EXPECT_EQ(parameters_of(twin, "subsurface").size(), 1u);
  twin.projector->optics = Optics{.f_number = 2.8, .focal_length_mm = 12.0, .focus_distance_mm = 300.0};
  EXPECT_TRUE(parameters_of(twin, "subsurface").empty());
}

}  // namespace
}  // namespace fringetwin::compare::subsurface_refined_test
