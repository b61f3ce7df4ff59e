// SPDX-License-Identifier: Apache-2.0
// Light that goes below a surface, as the reference in double precision sees it: it is named, and found back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "compare/causes/causes.hpp"
#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameters.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::subsurface_refined_test {
namespace {

using ::testing::ElementsAre;

using namespace planted_samples;

constexpr double kSeenNoiseDn = 0.5;

/// Twice the usual window: in that one, with less noise, the search names it only beside a second cause.
Twin rig() { return testing::window_on_the_sphere(2 * kWidth, 2 * kHeight); }

Twin with_path(double mean_free_path_mm) {
  Twin twin = rig();
  twin.objects[0].material.mean_free_path_mm = mean_free_path_mm;
  return twin;
}

/// What both cameras see of a twin by the reference, with noise.
struct Seen {
  explicit Seen(const Twin& truth) : recorded(traced_by_reference(truth)) {}
  Images recorded;
  std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity{testing::needed_renderer(), samples_of(recorded, same, frames, kSeenNoiseDn)};
};

TEST(SubsurfaceRefined, IsNamed) {
  REQUIRE_RENDERER();
  for (const double path_mm : {0.3, 1.0, 3.0}) {
    Seen seen(with_path(path_mm));
    const Causes causes = find_causes(seen.sensitivity, rig());
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
      Seen seen(with_path(path_mm));
      const Twin twin = with_path(start_mm);
      GroupFit fit(seen.sensitivity, twin, parameters_of(twin, "subsurface"), {.exact = true});
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
  Seen seen(coaxial(0.5));
  const Twin twin = coaxial(0.0);
  GroupFit fit(seen.sensitivity, twin, parameters_of(twin, "subsurface"), {.exact = true});
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
