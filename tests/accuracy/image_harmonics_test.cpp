// SPDX-License-Identifier: Apache-2.0
// Fringes that have another waveform in some images. Against the reference, which adds waves one by one where
// the renderer sums up Fourier series; against contrast, which is a first harmonic of all images; off without
// a trace.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes                                                    |
// | 2e-6      | of the light   | single precision: sums of 3 terms, 6e-8 each, factors rounded before |
// | 1e-5      | of the light   | phase in fp32, 5e-5 rad, times the sum of order times amplitude, 0.1 |
// | 0         |                | off = bitwise the same image                                         |
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/tilted_window.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::image_harmonics_test {
namespace {

constexpr double pi = std::numbers::pi;

Twin window(const Eigen::Vector3d& at_mm = {0, 0, 290}) { return tilted_window(12, at_mm); }

/// Every third image has a waveform of its own; some have contrast alone.
Twin with_waveforms(Twin twin) {
  const auto sequence = expand_sequence(twin.fringes);
  twin.fringes.image_harmonics.assign(sequence.size(), {});
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const double size = 0.01 * std::sin(1.0 + static_cast<double>(i));
    if (sequence[i].kind != PatternSpec::Kind::phase_step) continue;
    if (i % 3 == 1)
      twin.fringes.image_harmonics[i] = {{-0.03, 0.01}, {size, -0.5 * size}, {}, {0.4 * size, size}};
    if (i % 6 == 2) twin.fringes.image_harmonics[i] = {{size, 0.0}};
  }
  return twin;
}

Twin with_harmonics(Twin twin) {
  for (DirectionFringes& d : twin.fringes.directions)
    d.harmonics.assign(d.pitches_px.size(), {{0.004, -0.011}, {-0.003, 0.008}});
  return twin;
}

TEST(ImageHarmonics, OffChangesNoBit) {
  REQUIRE_RENDERER();
  for (Twin twin : {window(), with_harmonics(window())}) {
    Twin zero = twin;
    zero.fringes.image_harmonics.assign(36, {{0.0, 0.0}, {0.0, 0.0}});
    expect_same_bits(twin, zero);
    expect_same_bits(shared_renderer()->render(twin, 0, render::choose_sampling(twin)),
                     shared_renderer()->render(zero, 0, render::choose_sampling(zero)));
  }
}

// Beside harmonics of all images and without, formed from the fundamental and traced, through blur, halo,
// response, contrast of the pitches, defocus, below the surface, along both axes.
TEST(ImageHarmonics, AgreeWithTheReference) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y}) {
    Twin twin = window();
    twin.fringes.directions[0].axis = axis;
    expect_agreement(with_waveforms(twin), "images", 50, 7);
    twin = with_harmonics(with_waveforms(window({-60, -45, 290})));
    twin.fringes.directions[0].axis = axis;
    twin.projector->blur_px = 1.2;
    expect_agreement(twin, "images, harmonics, blur", 50, 7);
  }
  const Twin corner = with_harmonics(with_waveforms(window({60, 35, 290})));
  Twin twin = corner;
  twin.fringes.directions[0].contrast = {1.0, 0.7, 0.9};
  expect_agreement(twin, "images, contrast", 50, 7);
  twin.fringes.directions[0].harmonics_field = {{{0.02, 0.0}}, {{0.0, 0.01}}};
  expect_agreement(twin, "images, contrast, field", 50, 7);
  twin = corner;
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(twin, "images, gamma", 50, 7);
  twin = corner;
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  expect_agreement(twin, "images, defocus", 100, 6);
  twin = corner;
  twin.projector->blur_px = 1.2;
  twin.projector->halo = {{.share = 0.2, .sigma_px = 5.0}};
  expect_agreement(twin, "images, halo", 50, 7);
  twin = corner;
  twin.objects[0].material.mean_free_path_mm = 0.5;
  expect_agreement(twin, "images, subsurface", 50, 7);
}

/// The image must be that of a twin all of whose fringes have these harmonics, whatever else it has, and the
/// others do not care which image has them.
void expect_as_of_all(const Twin& twin, std::size_t image, const std::string& what) {
  const Harmonics own{{0.0, 0.0}, {0.01, -0.02}, {}, {0.0, 0.005}};
  Twin single = twin, next = twin, all = twin;
  for (Twin* t : {&single, &next})
    t->fringes.image_harmonics.assign(expand_sequence(twin.fringes).size(), {});
  single.fringes.image_harmonics[image] = next.fringes.image_harmonics[image - 1] = own;
  for (DirectionFringes& d : all.fringes.directions)
    d.harmonics.assign(d.pitches_px.size(), Harmonics(own.begin() + 1, own.end()));
  const auto a = render_fixed(single), b = render_fixed(all), other = render_fixed(next);
  double changed = 0.0;
  for (std::size_t k = 0; k < a.irradiance[image].size(); ++k) {
    const auto seen = static_cast<double>(a.irradiance[image].data[k]);
    ASSERT_NEAR(seen, static_cast<double>(b.irradiance[image].data[k]), 2e-6 * 60.0) << what;
    changed = std::max(changed, std::abs(seen - static_cast<double>(other.irradiance[image].data[k])));
  }
  EXPECT_GT(changed, 0.1) << what;
  for (std::size_t i = 0; i < a.irradiance.size(); ++i)
    if (i != image && i != image - 1) {
      EXPECT_EQ(a.irradiance[i].data, other.irradiance[i].data) << what << ' ' << i;
    }
}

TEST(ImageHarmonics, AreThoseOfAllFringesInOneImage) {
  REQUIRE_RENDERER();
  const Twin plain = window();
  Twin twin = plain;
  const std::size_t n = expand_sequence(twin.fringes).size();
  for (std::size_t i = 0; i < n; ++i) {
    twin.projector->image_shifts_px.push_back(0.3 * std::sin(static_cast<double>(i)));
    twin.projector->light_factors.push_back(1.0 + 0.05 * std::cos(static_cast<double>(i)));
  }
  expect_as_of_all(twin, 17, "shifts and light");
  twin = window_on_a_corner(0.8, 80, 60);
  twin.fringes.steps = 12;
  twin.render.bounces = 1;
  expect_as_of_all(twin, 17, "bounces");
  twin = plain;
  twin.fringes.directions.push_back(twin.fringes.directions[0]);
  twin.fringes.directions[1].axis = Axis::y;
  expect_as_of_all(twin, 36 + 17, "a second direction");
  twin = plain;
  twin.objects[0].motion = {0.5, 0.0, 0.0};
  expect_as_of_all(twin, 5, "motion");
  twin = plain;
  twin.fringes.unwrap = Unwrap::gray;
  DirectionFringes& d = twin.fringes.directions[0];
  d.pitches_px = {13.0}, d.phase_origin_px = {0.0};
  d.gray = GrayCode{.bits = 7, .complementary = true};
  expect_as_of_all(twin, 11, "a code behind");
}

// A contrast c is a first harmonic of (c - 1) times the amplitude, of all images alike.
TEST(ImageHarmonics, OfTheFirstOrderAreContrast) {
  REQUIRE_RENDERER();
  Twin contrast = window(), waveform = window();
  contrast.fringes.directions[0].contrast = {0.9, 0.9, 0.9};
  waveform.fringes.image_harmonics.assign(36, {{-0.1 * waveform.fringes.amplitude, 0.0}});
  const auto a = render_fixed(contrast), b = render_fixed(waveform);
  for (std::size_t i = 0; i < a.irradiance.size(); ++i)
    for (std::size_t k = 0; k < a.irradiance[i].size(); ++k)
      ASSERT_NEAR(a.irradiance[i].data[k], b.irradiance[i].data[k], 2e-6 * 40.0);
}

// By the plain formula, at single rays; images without a list stay as they are, to the bit.
TEST(ImageHarmonics, AreAddedToOneImage) {
  REQUIRE_RENDERER();
  const Twin without = window();
  Twin twin = without;
  twin.fringes.image_harmonics.assign(36, {});
  twin.fringes.image_harmonics[17] = {{-0.05, 0.0}, {0.0, 0.02}};
  const render::Sampling one_ray{Sampler::gauss, 1};
  const auto with = shared_renderer()->render(twin, 0, one_ray),
             plain = shared_renderer()->render(without, 0, one_ray);
  const render::Reference reference(without);
  const PatternSpec spec = expand_sequence(twin.fringes)[17];
  const double pitch_px = twin.fringes.directions[0].pitches_px[static_cast<std::size_t>(spec.pitch)];
  for (int x = 4; x < 80; x += 9) {
    const auto s = reference.sample(0, {static_cast<double>(x), 30.0});
    ASSERT_TRUE(s.lit);
    const double t = 2.0 * pi * (s.projector_px.x() / pitch_px + spec.step / 12.0);
    const double more = with.irradiance[17](x, 30) - plain.irradiance[17](x, 30);
    EXPECT_NEAR(more, s.weight * (0.02 * std::sin(2.0 * t) - 0.05 * std::cos(t)), 1e-5 * s.weight);
    for (const std::size_t other : {0U, 16U, 18U, 35U})
      EXPECT_NEAR(with.irradiance[other](x, 30), plain.irradiance[other](x, 30), 2e-6 * s.weight);
  }
}

TEST(ImageHarmonics, AreRefusedWhereEachStepIsEvaluatedDirectly) {
  REQUIRE_RENDERER();
  Twin pixels = with_waveforms(window());
  pixels.projector->pixel_structure = true;
  EXPECT_THROW(render_fixed(pixels), UserError);
  Twin sharp = with_waveforms(window());
  sharp.fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  EXPECT_THROW(render_fixed(sharp), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::image_harmonics_test
