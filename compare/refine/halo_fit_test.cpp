// SPDX-License-Identifier: Apache-2.0
// A halo of the projector, planted into gray values with noise that the double-precision reference's light
// makes, is found by the fit that `--refine halo` makes: from another halo, beside a wrong blur.
//
// | check             | tolerance | origin                                                             |
// |-------------------|-----------|--------------------------------------------------------------------|
// | planted value     | 3 sigma   | required; five numbers, normal: one seed in 74                     |
// | sigma of a share  | 5e-3      | 0.3 DN of 200 DN, 38,400 values, most of them in no edge: 1e-3     |
// | chi2              | 1.02      | 38,400 values: sqrt(2/n) = 0.0072                                  |
// | derivative        | 1 %       | of its size: a central difference that bends by 3 % is 0.1 % off,  |
// |                   |           | edges with 9 points per pixel against 16 by 0.5 %                  |
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "compare/causes/group_fit.hpp"
#include "compare/parameters/parameters.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::halo_fit_test {
namespace {

using namespace planted_samples;

const std::vector<Halo> kPlanted{{.share = 0.2, .sigma_px = 5.0}, {.share = 0.1, .sigma_px = 30.0}};

/// Ten bits of a Gray code of words of 8 px, with their inverses, by a projector whose pixels are a fifth of
/// a camera's: the window is 240 of them wide, many times the halo.
Twin coded_window() {
  Twin twin = testing::left_window({0, 0, 290}, kWidth, kHeight);
  twin = testing::with_object(twin, "plane", testing::tilted_plane());
  constexpr int kFiner = 5;
  Projector& p = *twin.projector;
  std::vector<double> k = p.lens.intrinsics();
  for (const std::size_t i : {0, 1}) k[i] *= kFiner;
  for (const std::size_t i : {2, 3}) k[i] = kFiner * (k[i] + 0.5) - 0.5;
  p.lens = Lens(p.lens.model(), k, {kFiner * p.lens.width(), kFiner * p.lens.height()}, "test");
  p.blur_px = 1.5;
  twin.fringes.steps = 0;
  twin.fringes.unwrap = Unwrap::gray;
  twin.fringes.directions[0] = {
      Axis::x, {8.0}, {-0.5}, GrayCode{.bits = 10, .threshold = GrayCode::Threshold::inverse}};
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
  Twin twin = with_halo(coded_window(), {{.share = 0.1, .sigma_px = 7.0}, {.share = 0.05, .sigma_px = 20.0}});
  twin.projector->blur_px = 1.7;
  fit_to(truth, twin, {"blur", "halo"}, [&](const GroupFit& fit) {
    const std::vector<double> planted{2.25, 0.2, 5.0, 0.1, 30.0};
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

// A change of width that changes the images by 2 % is as large as the width itself: its slope was 12 % off.
TEST(HaloFit, DerivativeOfAWidthIsThatOfTheReference) {
  const Twin twin = with_halo(coded_window(), kPlanted);
  const Images images = rendered(twin);
  const std::vector<CameraImages> frames = frames_of(images);
  Sensitivity sensitivity(testing::needed_renderer(), samples_of(images, same, frames));
  const std::vector<Parameter> all = parameters(twin, {"blur", "halo"});
  const Sensitivity::Columns columns =
      sensitivity.columns(twin, all, start_values(all), Sensitivity::Derivative::exact);
  const std::size_t at = 4;
  ASSERT_EQ(all[at].name, "projector.halo.2.sigma_px");
  const double step = 0.02 * all[at].start;
  const auto traced_at = [&](double value) {
    Eigen::VectorXd values = start_values(all);
    values[at] = value;
    return traced_by_reference(with_values(twin, all, values));
  };
  const Images more = traced_at(all[at].start + step), less = traced_at(all[at].start - step);
  double error2 = 0.0, size2 = 0.0;
  for (std::size_t i = 0; i < columns.each[at][0].size(); ++i) {
    const std::size_t image = i % more[0].size(), pixel = i / more[0].size();
    const double wanted =
        static_cast<double>(more[0][image].data[pixel] - less[0][image].data[pixel]) / (2.0 * step);
    error2 += std::pow(static_cast<double>(columns.each[at][0][i]) - wanted, 2);
    size2 += wanted * wanted;
  }
  EXPECT_LT(std::sqrt(error2 / size2), 0.01) << all[at].name;
}

// From none: shares first, then widths.
TEST(HaloFit, FindsAHaloThatTheTwinLacks) {
  const Twin truth = with_halo(coded_window(), kPlanted), twin = with_empty_halo(coded_window());
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  Sensitivity sensitivity(testing::needed_renderer(), samples_of(traced_by_reference(truth), same, frames));
  sensitivity.choose_points(twin);
  const std::vector<Parameter> all = parameters(twin, {"halo"});
  GroupFit fit(sensitivity, twin, all, {.exact = true});
  EXPECT_TRUE(fit.start_at(with_light_in_halo(all, start_values(all))));
  fit.run();
  EXPECT_TRUE(fit.converged());
  const std::vector<double> planted{0.2, 5.0, 0.1, 30.0};
  ASSERT_EQ(all.size(), planted.size());
  for (std::size_t k = 0; k < planted.size(); ++k) {
    EXPECT_TRUE(fit.known()[k].told) << all[k].name;
    EXPECT_NEAR(fit.known()[k].value, planted[k], 3.0 * fit.known()[k].sigma) << all[k].name;
  }
  EXPECT_LT(fit.chi2(), 1.02);
}

// Images of a code that are exposed by themselves: each has a factor of its own in every fit.
TEST(HaloFit, IsFoundBesideOtherLightOfTheCode) {
  constexpr std::size_t kCommon = 4;  // images whose light is the twin's
  const auto light_of = [](int image) {
    return image < static_cast<int>(kCommon) ? 1.0 : 1.03 + 0.002 * image;
  };
  const Twin truth = with_halo(coded_window(), kPlanted);
  const Twin twin =
      with_halo(coded_window(), {{.share = 0.1, .sigma_px = 7.0}, {.share = 0.05, .sigma_px = 20.0}});
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  const Images traced = traced_by_reference(truth);
  std::vector<GridSamples> samples = samples_of(
      traced, [&](double e, std::size_t, int image, int, int) { return light_of(image) * e; }, frames);
  const std::vector<Parameter> all = parameters(twin, {"halo"});
  Sensitivity untold(testing::needed_renderer(), samples);
  GroupFit fit_of_untold(untold, twin, all, {.exact = true});
  fit_of_untold.run();
  EXPECT_GT(fit_of_untold.chi2(), 2.0);
  for (std::size_t k = kCommon; k < samples[0].images.size(); ++k) samples[0].lit_apart.push_back(k);
  samples[0].light.assign(samples[0].images.size(), 1.0);
  Sensitivity sensitivity(testing::needed_renderer(), samples);
  GroupFit fit(sensitivity, twin, all, {.exact = true});
  fit.run();
  fit.settle_sensors();
  EXPECT_TRUE(fit.converged());
  EXPECT_LT(fit.chi2(), 1.02);
  const std::vector<double> planted{0.2, 5.0, 0.1, 30.0};
  for (std::size_t k = 0; k < planted.size(); ++k)
    EXPECT_NEAR(fit.known()[k].value, planted[k], 3.0 * fit.known()[k].sigma) << all[k].name;
  const GridSamples& s = sensitivity.samples()[0];
  const auto mean_of = [&](std::size_t k) {
    return std::accumulate(traced[0][k].data.begin(), traced[0][k].data.end(), 0.0) /
           static_cast<double>(traced[0][k].size());
  };
  int n_told = 0;
  for (std::size_t k = kCommon; k < s.images.size(); ++k) {
    if (mean_of(k) < 1.0) continue;  // of 5: dark all over, where the prior holds it
    EXPECT_NEAR(s.light[k], light_of(s.images[k]), 3e-3)
        << k;  // 0.3 DN of 100 DN, 1920 values: beside a halo
    ++n_told;
  }
  EXPECT_GE(n_told, 13);
}

TEST(HaloFit, AnEmptyHaloIsGivenAndTakenWhereThereCanBeOne) {
  Twin twin = coded_window();
  const Twin empty = with_empty_halo(twin);
  ASSERT_EQ(empty.projector->halo.size(), 2u);
  EXPECT_EQ(empty.projector->halo[0].share, 0.0);
  EXPECT_LT(empty.projector->halo[0].sigma_px, empty.projector->halo[1].sigma_px);
  Twin taken = empty;
  taken.projector->halo[1].share = 0.1;
  drop_empty_halo(taken);
  ASSERT_EQ(taken.projector->halo.size(), 1u);
  EXPECT_EQ(taken.projector->halo[0].share, 0.1);
  EXPECT_EQ(with_empty_halo(taken).projector->halo.size(), 1u);  // it has one
  twin.projector->blur_px = 0.0;                                 // a halo goes with a blur
  EXPECT_TRUE(with_empty_halo(twin).projector->halo.empty());
}

TEST(HaloFit, IsNotOfferedWhereNothingTellsIt) {
  const std::vector<Halo> one{{.share = 0.1, .sigma_px = 5.0}};
  Twin twin = coded_window();
  EXPECT_TRUE(refinable_parameters_of(twin, "halo").empty());  // a fit needs a halo to begin with
  twin.projector->halo = one;
  EXPECT_EQ(parameters_of(twin, "halo").size(), 2u);
  twin.fringes.steps = 4;  // then the bits are asked beside the steps of one pitch
  EXPECT_EQ(refinable_parameters_of(twin, "halo").size(), 2u);
  twin.fringes.directions[0].gray.reset();
  EXPECT_TRUE(refinable_parameters_of(twin, "halo").empty());  // of which none tells it
  Twin steps = with_halo(testing::window_on_the_sphere(kWidth, kHeight), one);
  steps.projector->blur_px = 0.5;
  EXPECT_EQ(refinable_parameters_of(steps, "halo").size(), 2u);
  EXPECT_TRUE(
      parameters_of(steps, "halo").empty());  // no cause: the pitches' contrasts are other effects', too
}

}  // namespace
}  // namespace fringetwin::compare::halo_fit_test
