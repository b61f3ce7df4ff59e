// SPDX-License-Identifier: Apache-2.0
// A halo of the projector, planted into gray values with noise that the double-precision reference's light
// makes, is found by the fit that `--refine halo` makes: from another halo, beside a wrong blur, from none.
//
// | check             | tolerance | origin                                                             |
// |-------------------|-----------|--------------------------------------------------------------------|
// | planted value     | 3 sigma   | required; five numbers, normal: one seed in 74                     |
// | sigma of a share  | 5e-3      | 0.3 DN of 200 DN, 50,000 values, most of them in no edge: 1e-3     |
// | chi2              | 1.02      | 49,920 values: sqrt(2/n) = 0.0063                                  |
// | light of a ladder | 0.01      | a tail of 1.7 px by one of 2 px beside a free blur: 0.006 of a wave|
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/parameters.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::halo_fit_test {
namespace {

using namespace planted_samples;

const std::vector<Halo> kPlanted{{.share = 0.2, .sigma_px = 1.7}, {.share = 0.1, .sigma_px = 38.0}};

/// Nine bits of a Gray code of words of 4 px, and four steps.
Twin coded_window() {
  Twin twin = testing::window_on_the_sphere(kWidth, kHeight);
  twin.fringes.steps = 4;
  twin.fringes.unwrap = Unwrap::gray;
  twin.fringes.directions[0] = {Axis::x, {4.0}, {-0.5}, GrayCode{.bits = 9}};
  twin.projector->blur_px = 0.6;
  return twin;
}

Twin with_halo(Twin twin, const std::vector<Halo>& halo) {
  twin.projector->halo = halo;
  return twin;
}

std::vector<Parameter> parameters(const Twin& twin, const std::vector<std::string>& groups) {
  std::vector<Parameter> all;
  for (const std::string& group : groups)
    for (Parameter& p : parameters_of(twin, group)) all.push_back(std::move(p));
  return all;
}

/// Fits groups of this twin to what the reference says of another, and calls check(fit).
template <class Check>
void fit_to(const Twin& truth, const Twin& twin, const std::vector<std::string>& groups, Check check) {
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  Sensitivity sensitivity(testing::needed_renderer(), samples_of(traced_by_reference(truth), same, frames));
  GroupFit fit(sensitivity, twin, parameters(twin, groups), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  check(fit);
}

TEST(HaloFit, FindsSharesAndWidthsBesideAWrongBlur) {
  const Twin truth = with_halo(coded_window(), kPlanted);
  Twin twin = with_halo(coded_window(), {{.share = 0.1, .sigma_px = 2.5}, {.share = 0.05, .sigma_px = 25.0}});
  twin.projector->blur_px = 0.8;
  fit_to(truth, twin, {"blur", "halo"}, [&](const GroupFit& fit) {
    const std::vector<double> planted{0.36, 0.2, 1.7, 0.1, 38.0};
    ASSERT_EQ(fit.parameters().size(), planted.size());
    for (std::size_t k = 0; k < planted.size(); ++k) {
      const Parameter& p = fit.parameters()[k];
      EXPECT_TRUE(fit.known()[k].told) << p.name;
      EXPECT_NEAR(fit.known()[k].value, planted[k], 3.0 * fit.known()[k].sigma) << p.name;
      if (p.name.ends_with(".share")) {
        EXPECT_LT(fit.known()[k].sigma, 5e-3) << p.name;
      }
    }
    EXPECT_LT(fit.chi2(), 1.02);
  });
}

// Widths of a ladder stand for others; what is left of any wave is that of the planted light.
TEST(HaloFit, BeginsFromNone) {
  const Twin truth = with_halo(coded_window(), kPlanted), twin = coded_window();
  fit_to(truth, twin, {"blur", "halo"}, [&](const GroupFit& fit) {
    const Twin found = fit.twin();
    EXPECT_EQ(found.projector->halo.size(), 2u);
    for (const double pitch_px : {4.0, 8.0, 16.0, 64.0, 256.0}) {
      const auto left = [&](const Twin& t) {
        const double u = std::numbers::pi * t.projector->blur_px / pitch_px;
        return std::exp(-2.0 * u * u) * t.projector->halo_attenuation(1.0 / pitch_px);
      };
      EXPECT_NEAR(left(found), left(truth), 0.01) << pitch_px;
    }
  });
}

TEST(HaloFit, IsNotOfferedWhereNothingTellsIt) {
  Twin twin = coded_window();
  EXPECT_EQ(parameters_of(twin, "halo").size(), 2u);
  twin.projector->blur_px = 0.0;
  EXPECT_TRUE(parameters_of(twin, "halo").empty());
  Twin steps = testing::window_on_the_sphere(kWidth, kHeight);
  steps.projector->blur_px = 0.5;
  EXPECT_EQ(refinable_parameters_of(steps, "halo").size(), 2u);
  EXPECT_TRUE(
      parameters_of(steps, "halo").empty());  // no cause: the pitches' contrasts are other effects', too
  DirectionFringes& d = steps.fringes.directions[0];
  d.pitches_px.resize(1), d.phase_origin_px.resize(1);
  EXPECT_TRUE(refinable_parameters_of(steps, "halo").empty());
}

}  // namespace
}  // namespace fringetwin::compare::halo_fit_test
