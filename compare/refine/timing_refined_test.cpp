// SPDX-License-Identifier: Apache-2.0
// Exposures that the double-precision reference made, with noise, as `--refine timing` fits them.
//
// | check                | tolerance    | origin                                                            |
// |----------------------|--------------|-------------------------------------------------------------------|
// | what was planted     | 3 sigma      | required; 4 numbers: one seed in 93                               |
// | images on time       | 3.5 sigma    | 22 numbers, normal: one seed in 98                                |
// | the same at borders  | 1e-3         | where a fit between two slopes counts as settled                  |
// | sigma                | 2e-3         | a fiftieth of the planted 0.1; 0.3 DN of 80 in 1,920 pixels: 1e-4 |
// | chi2                 | 0.02         | 46,080 values: sqrt(2/n) = 0.0066                                 |
// | every third row      | 2e-4         | phases of some turns in single precision: 1e-5 of light of 10     |
#include <gtest/gtest.h>

#include <cmath>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/refine/refine_start.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::timing_refined_test {
namespace {

using namespace planted_samples;

Twin on_the_sphere() { return testing::window_on_the_sphere(kWidth, kHeight); }

double planted_at(const Twin& twin, const std::string& name) {
  for (const Parameter& p : parameters_of(twin, "timing"))
    if (p.name == name) return p.start;
  ADD_FAILURE() << "no parameter " << name;
  return 0.0;
}

/// Fits the timing of a twin to what the reference sees of another.
void expect_refined_back(const Twin& twin, const Twin& truth) {
  const Images recorded = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity(testing::needed_renderer(), samples_of(recorded, same, frames));
  GroupFit fit(sensitivity, twin, refinable_parameters_of(twin, "timing"), {.exact = true});
  start_late_or_early(fit);
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);
  ASSERT_EQ(fit.parameters().size(), 26u);
  for (std::size_t k = 0; k < fit.parameters().size(); ++k) {
    const GroupFit::Known& found = fit.known()[k];
    const std::string& name = fit.parameters()[k].name;
    const double planted = planted_at(truth, name);
    EXPECT_NEAR(found.value, planted, (planted != 0.0 ? 3.0 : 3.5) * found.sigma) << name;
    EXPECT_LT(found.sigma, 2e-3) << name;
    EXPECT_EQ(planted_at(fit.twin(), name), found.value) << name;
  }
}

// One image of the left camera is late by 0.1, one of the right one early; both have rolling shutters.
TEST(TimingRefined, LateImagesAndReadOutsAreFoundFromNone) {
  REQUIRE_RENDERER();
  const Twin twin = on_the_sphere();
  Twin truth = twin;
  std::vector<double> late(12, 0.0), early(12, 0.0);
  late[5] = 0.1;
  early[8] = -0.07;
  truth.cameras[0].timing = ExposureTiming{.exposure = 1.0, .read_out = 0.3, .late = late};
  truth.cameras[1].timing = ExposureTiming{.exposure = 1.0, .read_out = 0.15, .late = early};
  expect_refined_back(twin, truth);
}

// Without read-outs every exposure on time stands at the border of its pattern, where later and earlier are
// different slopes: the fit comes to rest there.
TEST(TimingRefined, ExposuresOnTimeComeToRestBetweenTwoSlopes) {
  REQUIRE_RENDERER();
  const Twin twin = on_the_sphere();
  Twin truth = twin;
  for (Camera& camera : truth.cameras) {
    std::vector<double> late(12, 0.0);
    late[5] = 0.1;
    late[8] = -0.07;
    camera.timing = ExposureTiming{.exposure = 1.0, .read_out = 0.0, .late = late};
  }
  const Images recorded = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(recorded);
  Sensitivity sensitivity(testing::needed_renderer(), samples_of(recorded, same, frames));
  std::vector<Parameter> parameters = refinable_parameters_of(twin, "timing");
  std::erase_if(parameters, [](const Parameter& p) { return p.name.ends_with(".read_out"); });
  GroupFit fit(sensitivity, twin, parameters, {.exact = true});
  start_late_or_early(fit);
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_NEAR(fit.chi2(), 1.0, 0.02);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const GroupFit::Known& found = fit.known()[k];
    const double planted = planted_at(truth, parameters[k].name);
    EXPECT_NEAR(found.value, planted, std::max(3.5 * found.sigma, planted == 0.0 ? 1e-3 : 0.0))
        << parameters[k].name;
  }
}

// Every third pixel of a rolling shutter is exposed when that pixel of the whole image is.
TEST(TimingRefined, AThinnedImageKeepsItsTimes) {
  REQUIRE_RENDERER();
  Twin twin = on_the_sphere();
  twin.cameras[0].timing = ExposureTiming{.exposure = 1.0, .read_out = 0.5, .late = {0.1}};
  const GridView all{1, 0, 0, kWidth, kHeight}, third{3, 1, 2, 15, 12};
  const std::vector<ImageF> whole = render_grid(testing::needed_renderer(), twin, 0, all, 9),
                            thinned = render_grid(testing::needed_renderer(), twin, 0, third, 9);
  twin.cameras[0].timing.reset();
  const std::vector<ImageF> on_time = render_grid(testing::needed_renderer(), twin, 0, third, 9);
  double changed = 0.0;
  for (std::size_t k = 0; k < whole.size(); ++k)
    for (int y = 0; y < third.height; ++y)
      for (int x = 0; x < third.width; ++x) {
        const auto seen = static_cast<double>(thinned[k](x, y));
        ASSERT_NEAR(seen, static_cast<double>(whole[k](1 + 3 * x, 2 + 3 * y)), 2e-4)
            << k << ' ' << x << ' ' << y;
        changed = std::max(changed, std::abs(seen - static_cast<double>(on_time[k](x, y))));
      }
  EXPECT_GT(changed, 0.5);
}

}  // namespace
}  // namespace fringetwin::compare::timing_refined_test
