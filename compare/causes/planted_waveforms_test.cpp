// SPDX-License-Identifier: Apache-2.0
// What the light of fringes has besides what is shown, planted into gray values with noise by the reference
// in double precision, is found by the fit to convergence: harmonics, alike everywhere or not, contrast of
// pitches, waveforms of single images, waves of the raster.
//
// | check                 | tolerance      | origin                                                |
// |-----------------------|----------------|-------------------------------------------------------|
// | harmonics             | 3 sigma        | required; ten numbers, normal: one seed in 40         |
// | their sigma           | 1e-3           | 0.3 DN of 200 DN, blur leaves order 6 a fifteenth     |
// | field of harmonics    | 3 sigma        | required; seven numbers, normal: one seed in 53       |
// | contrast              | 3 sigma        | required; two numbers, normal: one seed in 185        |
// | its sigma             | 2e-3           | a tenth of the least that is planted, 0.02            |
// | waveforms of images   | 4 sigma        | 103 numbers, normal: one seed in 155                  |
// | their sigma           | 1e-3           | 0.3 DN of 200 DN in one image of 8                    |
// | waves of the raster   | 4 sigma        | 13 numbers, normal: one seed in 1200                  |
// | their sigma           | 1e-3           | 0.3 DN of 200 DN                                      |
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/parameters.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/compare/planted_samples.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::planted_waveforms_test {
namespace {

using namespace planted_samples;

Twin window_on_the_sphere() { return testing::window_on_the_sphere(kWidth, kHeight); }

render::Renderer& renderer() { return testing::needed_renderer(); }

// In phase and in quadrature, beside harmonics that the twin knows, by the fit to convergence; the truth is
// the double-precision reference's, which knows no Fourier series of a pattern. What is found is a twin's.
TEST(PlantedWaveforms, HarmonicsOfTheFringes) {
  Twin twin = window_on_the_sphere();
  twin.fringes.steps = 8;
  twin.projector->blur_px = 0.8;
  DirectionFringes& fringes = twin.fringes.directions[0];
  fringes.harmonics.assign(3, {{0.004, 0.0}});
  Twin truth = twin;
  const Harmonics planted{{0.008, -0.011}, {-0.003, 0.009}, {0.0, 0.005}, {0.004, -0.003}, {-0.004, 0.006}};
  truth.fringes.directions[0].harmonics.assign(3, planted);
  const Images images = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "harmonics"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  ASSERT_EQ(fit.parameters().size(), 10u);  // orders 2 ... 6: 7 and 9 cannot be told from the fundamental
  for (std::size_t k = 0; k < 10; ++k) {
    const double value = k % 2 == 0 ? planted[k / 2].cosine : planted[k / 2].sine;
    const GroupFit::Known& known = fit.known()[k];
    EXPECT_NEAR(known.value, value, 3.0 * known.sigma) << fit.parameters()[k].name;
    EXPECT_LT(known.sigma, 1e-3) << fit.parameters()[k].name;
  }
  EXPECT_LT(fit.chi2(), 1.05);
  const Harmonics found = fit.twin().fringes.directions[0].harmonics_of(2);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0].cosine, fit.known()[0].value);
  EXPECT_EQ(found[4].sine, fit.known()[9].value);
}

// Of two directions in the projector's image, beside harmonics that the twin lacks, too: the window is a
// tenth of that image wide, so few terms are asked for.
TEST(PlantedWaveforms, FieldOfTheHarmonics) {
  Twin twin = window_on_the_sphere();
  twin.fringes.steps = 8;
  Twin truth = twin;
  truth.fringes.directions[0].harmonics.assign(3, {{0.008, -0.011}, {-0.003, 0.009}});
  truth.fringes.directions[0].harmonics_field = {{{0.05, 0.0}, {0.0, -0.06}}, {{0.0, 0.07}}};
  const Images images = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  std::vector<Parameter> parameters;
  std::vector<double> planted;
  const auto take = [&](const std::string& group, const std::string& name, double value) {
    for (Parameter& p : parameters_of(twin, group))
      if (p.name == name) parameters.push_back(std::move(p)), planted.push_back(value);
  };
  take("harmonics", "projector.harmonic.2", 0.008);
  take("harmonics", "projector.harmonic.2.quadrature", -0.011);
  take("harmonics", "projector.harmonic.3", -0.003);
  take("harmonics", "projector.harmonic.3.quadrature", 0.009);
  take("harmonics_field", "projector.harmonics_field.1_0.2", 0.05);
  take("harmonics_field", "projector.harmonics_field.1_0.3.quadrature", -0.06);
  take("harmonics_field", "projector.harmonics_field.0_1.2.quadrature", 0.07);
  ASSERT_EQ(parameters.size(), 7u);
  GroupFit fit(sensitivity, twin, parameters, {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const GroupFit::Known& known = fit.known()[k];
    EXPECT_NEAR(known.value, planted[k], 3.0 * known.sigma) << parameters[k].name;
    EXPECT_LT(known.sigma, 0.02) << parameters[k].name;
  }
  EXPECT_LT(fit.chi2(), 1.05);
  EXPECT_EQ(fit.twin().fringes.directions[0].harmonics_field[0][0].cosine, fit.known()[4].value);
}

// Of two pitches, beside that of the widest, which is not asked for; a response bends the fringes.
TEST(PlantedWaveforms, ContrastOfThePitches) {
  Twin twin = window_on_the_sphere();
  twin.projector->response = {ProjectorResponse::Kind::gamma, 1.6, {}};
  DirectionFringes& fringes = twin.fringes.directions[0];
  fringes.contrast = {1.0, 1.0, 1.0};
  const auto widest =
      static_cast<std::size_t>(std::ranges::max_element(fringes.pitches_px) - fringes.pitches_px.begin());
  Twin truth = twin;
  std::vector<double>& planted = truth.fringes.directions[0].contrast;
  for (std::size_t p = 0; p < 3; ++p)
    if (p != widest) planted[p] = 0.98 - 0.03 * static_cast<double>(p);
  const Images images = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  GroupFit fit(sensitivity, twin, parameters_of(twin, "contrast"), {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  ASSERT_EQ(fit.parameters().size(), 2u);
  for (std::size_t p = 0, k = 0; p < 3; ++p) {
    const double found = fit.twin().fringes.directions[0].contrast_of(p);
    if (p == widest) {
      EXPECT_EQ(found, 1.0);
      continue;
    }
    const GroupFit::Known& known = fit.known()[k++];
    EXPECT_EQ(found, known.value);
    EXPECT_NEAR(found, planted[p], 3.0 * known.sigma) << p;
    EXPECT_LT(known.sigma, 2e-3) << p;
  }
  EXPECT_LT(fit.chi2(), 1.05);
}

// Two images whose exposures hold other parts of the projector's frames: less contrast, other harmonics, and
// fringes that lie further; beside harmonics of all images, light that differs, and an image with contrast of
// its own alone. What is found is a twin's.
TEST(PlantedWaveforms, OfSingleImages) {
  Twin twin = window_on_the_sphere();
  twin.fringes.steps = 8;
  twin.fringes.unwrap = Unwrap::none;
  DirectionFringes& fringes = twin.fringes.directions[0];
  fringes.pitches_px = {13.0}, fringes.phase_origin_px = {0.0};
  Twin truth = twin;
  truth.fringes.directions[0].harmonics.assign(1, {{0.008, -0.011}, {-0.003, 0.009}});
  truth.fringes.image_harmonics.assign(8, {});
  truth.fringes.image_harmonics[3] = {{-0.012, 0.0}, {0.006, -0.003}, {0.004, 0.005}, {}, {-0.007, 0.002}};
  truth.fringes.image_harmonics[6] = {{-0.015, 0.0}, {0.005, -0.004}, {0.004, 0.003}, {}, {-0.006, 0.0}};
  truth.fringes.image_harmonics[0] = {{0.02, 0.0}};
  for (int k = 0; k < 8; ++k) {
    truth.projector->light_factors.push_back(1.0 + 0.02 * std::sin(2.0 * k));
    truth.projector->image_shifts_px.push_back(k == 3 ? 0.1 : k == 6 ? 0.08 : 0.0);
  }
  const Images images = traced_by_reference(truth);
  const std::vector<CameraImages> frames = frames_of(rendered(twin));
  Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
  std::vector<Parameter> parameters;
  for (const char* group : {"harmonics", "light", "image_shift", "image_harmonics"})
    for (Parameter& p : parameters_of(twin, group)) parameters.push_back(std::move(p));
  ASSERT_EQ(parameters.size(), 10u + 7u + 8u + 8u * 11u);
  GroupFit fit(sensitivity, twin, parameters, {.exact = true});
  fit.run();
  EXPECT_TRUE(fit.converged());
  EXPECT_LT(fit.chi2(), 1.05);
  // of the harmonics the mean is that of all images; of contrast there is nothing else that has it
  const auto of_image = [&](const Twin& t, std::size_t image, std::size_t order) {
    const Harmonics& list = t.fringes.harmonics_of_image(image);
    return order <= list.size() ? list[order - 1] : Harmonic{};
  };
  const std::vector<Parameter>& all = fit.parameters();
  for (std::size_t image = 0; image < 8; ++image)
    for (std::size_t order = 1; order <= 6; ++order) {
      Harmonic mean;
      for (std::size_t i = 0; order > 1 && i < 8; ++i)
        mean.cosine += of_image(truth, i, order).cosine / 8.0,
            mean.sine += of_image(truth, i, order).sine / 8.0;
      const Harmonic planted = of_image(truth, image, order), found = of_image(fit.twin(), image, order);
      const std::string name = fmt::format("image_{}.harmonic.{}", image, order);
      const auto at = std::ranges::find(all, name, &Parameter::name);
      ASSERT_NE(at, all.end()) << name;
      const GroupFit::Known& known = fit.known()[static_cast<std::size_t>(at - all.begin())];
      EXPECT_EQ(found.cosine, known.value) << name;
      EXPECT_NEAR(known.value, planted.cosine - mean.cosine, 4.0 * known.sigma) << name;
      EXPECT_LT(known.sigma, 1e-3) << name;
      if (order == 1) continue;
      const GroupFit::Known& next = fit.known()[static_cast<std::size_t>(at - all.begin()) + 1];
      EXPECT_NEAR(next.value, planted.sine - mean.sine, 4.0 * next.sigma) << name << ".quadrature";
    }
}

// Of two pitches, which are sampled apart from one another, beside light, shifts and a pose; the raster is as
// wide as the twin says, or a little wider.
TEST(PlantedWaveforms, WavesOfTheRaster) {
  Twin twin = window_on_the_sphere();
  twin.fringes.steps = 5;
  twin.fringes.unwrap = Unwrap::none;
  twin.projector->blur_px = 0.5;
  DirectionFringes& fringes = twin.fringes.directions[0];
  fringes.pitches_px = {14.5, 13.0}, fringes.phase_origin_px = {2.0, -1.0};
  fringes.raster = {1.01, 8, {{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}}};
  Twin truth = twin;
  truth.fringes.directions[0].raster.waves = {{0.012, -0.005}, {0.0, 0.0}, {-0.004, 0.01}};
  for (int k = 0; k < 10; ++k) {
    truth.projector->light_factors.push_back(1.0 + 0.02 * std::sin(2.0 * k));
    truth.projector->image_shifts_px.push_back(k == 3 ? 0.1 : 0.0);
  }
  const auto find = [&](const Twin& start, const Twin& rig, std::vector<std::string> groups) {
    const Images images = traced_by_reference(rig);
    const std::vector<CameraImages> frames = frames_of(rendered(start));
    Sensitivity sensitivity(renderer(), samples_of(images, same, frames));
    std::vector<Parameter> parameters;
    for (const std::string& group : groups)
      for (Parameter& p : parameters_of(start, group)) parameters.push_back(std::move(p));
    GroupFit fit(sensitivity, start, parameters, {.exact = true});
    fit.run();
    EXPECT_TRUE(fit.converged());
    EXPECT_LT(fit.chi2(), 1.05);
    const Raster& planted = rig.fringes.directions[0].raster;
    std::size_t n = 0;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (parameters[k].group != "raster") continue;
      const std::size_t wave = n / 2;
      const double value = wave >= planted.waves.size() ? planted.pitch_px
                           : n % 2 == 0                 ? planted.waves[wave].cosine
                                                        : planted.waves[wave].sine;
      ++n;
      const GroupFit::Known& known = fit.known()[k];
      EXPECT_NEAR(known.value, value, 4.0 * known.sigma) << parameters[k].name;
      EXPECT_LT(known.sigma, 1e-3) << parameters[k].name;
    }
    return n;
  };
  EXPECT_EQ(find(twin, truth, {"raster", "light", "image_shift"}), 6u);  // no pitch without any wave
  Twin close = truth;
  close.fringes.directions[0].raster.pitch_px += 2e-4;  // half a radian over the projector's image
  close.fringes.directions[0].raster.waves[0].sine = 0.0;
  EXPECT_EQ(find(close, truth, {"raster"}), 7u);
}

}  // namespace
}  // namespace fringetwin::compare::planted_waveforms_test
