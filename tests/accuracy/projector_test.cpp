// SPDX-License-Identifier: Apache-2.0
// What the projector's optics and electronics do to the pattern: response carried as harmonics, defocus
// by depth, pixel raster, gaps, quantisation. Against the reference (which evaluates everything by other
// formulas) and against closed forms.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes; smooth patterns                                   |
// | 1e-5      | of fundamental | bound of the dropped harmonics: a tenth of phase_error_rad           |
// | 2e-6      | relative       | attenuation against Bessel's function, fp32                          |
// | 3e-4      | full scale rms | patterns with edges, both sides at the same sample points: some fall  |
// |           |                | on the other side of an edge by rounding                             |
// | 0         |                | off = bitwise the same image                                         |
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "render/pattern/response_series.hpp"
#include "render/pattern/waveform.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::projector_test {
namespace {

using render::PatternMethod;
constexpr double pi = std::numbers::pi;

Twin window(const Shape& shape, int width = 96, int height = 72) {
  return with_object(left_window({0, 0, 290}, width, height), "surface", shape);
}

Twin gray_window() {
  Twin twin = window(tilted_plane());
  DirectionFringes& d = twin.fringes.directions[0];
  d.pitches_px = {20.0};
  d.phase_origin_px = {-0.5};
  GrayCode gray;
  gray.bits = 6;
  gray.complementary = true;
  gray.offset_periods = 0.25;
  d.gray = gray;
  twin.fringes.unwrap = Unwrap::gray;
  return twin;
}

ProjectorResponse gamma(double exponent) { return {ProjectorResponse::Kind::gamma, exponent, {}}; }
ProjectorResponse table() { return {ProjectorResponse::Kind::table, 1.0, {0.02, 0.1, 0.35, 0.8, 0.97}}; }

render::RenderedCamera render_with(const Twin& twin, PatternMethod method) {
  shared_renderer()->set_tuning({.pattern_method = method});
  auto out = render_fixed(twin);
  shared_renderer()->set_tuning({});
  return out;
}

/// Renderer and reference at the same 4x4 points of each pixel: no quadrature error between them.
Agreement expect_agreement_point_by_point(const Twin& twin, const std::string& what, double limit) {
  const Agreement a =
      agreement(twin, 0, {Sampler::gauss, 16}, whole_image(twin, 0, 5), Pixels::interior, {.gauss_n = 4});
  std::cout << what << ": " << a.text() << "\n";
  EXPECT_GE(a.n, 200) << what;
  EXPECT_LE(a.gray_rms, limit) << what;
  return a;
}

// ---------------------------------------------------------------- harmonics

TEST(ResponseHarmonics, DroppedHarmonicsStayBelowTheBound) {
  Twin twin = window(frontal_plane());
  for (const auto& [response, blur] :
       {std::pair{gamma(2.2), 0.0}, {gamma(1.8), 0.5}, {gamma(0.45), 2.0}, {table(), 1.2}, {table(), 3.0}})
    for (const double bound : {1e-3, 1e-5}) {
      twin.projector->response = response;
      twin.projector->blur_px = blur;
      const auto s = render::short_series(*twin.projector, twin.fringes, 14.0, bound, 64);
      ASSERT_FALSE(s.a.empty());
      const auto all = render::cosine_series(response, 0.5, 0.5, 600);
      double dropped = 0.0;
      for (std::size_t k = s.a.size(); k < all.a.size(); ++k)
        dropped += std::abs(all.a[k]) * render::blur_attenuation(static_cast<int>(k), blur, 14.0);
      EXPECT_LE(dropped, bound * std::abs(all.a[1]) * render::blur_attenuation(1, blur, 14.0));
      std::cout << "bound " << bound << ": " << s.a.size() - 1 << " harmonics, dropped "
                << dropped / std::abs(all.a[1]) << "\n";
    }
  // Kinks without blur: hundreds of harmonics. Such a response is evaluated step by step.
  twin.projector->response = table();
  twin.projector->blur_px = 0.0;
  EXPECT_TRUE(render::short_series(*twin.projector, twin.fringes, 14.0, 1e-5, 16).a.empty());
  EXPECT_TRUE(render::choose_series(twin, PatternMethod::harmonics)[0][0].a.empty());
}

TEST(ResponseHarmonics, EqualTheStepsEvaluatedOneByOne) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  for (const auto& [response, blur, steps] :
       {std::tuple{gamma(2.2), 0.0, 4}, {gamma(2.2), 0.0, 12}, {gamma(1.8), 0.8, 5}, {table(), 2.0, 8}}) {
    twin.projector->response = response;
    twin.projector->blur_px = blur;
    twin.fringes.steps = steps;
    ASSERT_FALSE(render::choose_series(twin, PatternMethod::harmonics)[0][0].a.empty());
    const auto series = render_with(twin, PatternMethod::harmonics);
    const auto direct = render_with(twin, PatternMethod::direct);
    // dropped harmonics: 1e-5 of the fundamental (half of full scale, E up to 10); rounding: 1e-6 of E
    EXPECT_LE(largest_difference(series, direct), 10.0 * (1e-5 + 2e-6));
    const auto automatic = render_with(twin, PatternMethod::automatic);
    const bool by_series = !render::choose_series(twin)[0][0].a.empty();
    expect_same_bits(automatic, by_series ? series : direct);
  }
}

TEST(ResponseHarmonics, AgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  twin.fringes.steps = 12;
  twin.projector->response = gamma(2.2);
  ASSERT_FALSE(render::choose_series(twin)[0][0].a.empty());  // the automatic choice with 12 steps
  expect_agreement(twin, "gamma 2.2, 12 steps", 200, 5);
  twin.projector->response = table();
  twin.projector->blur_px = 1.5;
  ASSERT_FALSE(render::choose_series(twin)[0][0].a.empty());
  expect_agreement(twin, "table and blur, 12 steps", 200, 5);
}

// ---------------------------------------------------------------- defocus

TEST(ProjectorDefocus, AttenuatesEachPitchByTheDiskTransform) {
  REQUIRE_RENDERER();
  Twin twin = window(frontal_plane());
  const auto sharp = render_with(twin, PatternMethod::automatic);
  const render::Reference reference(twin);
  for (const double focus_mm : {200.0, 600.0}) {
    twin.projector->optics = Optics{2.0, 30.0, focus_mm};
    const auto soft = render_with(twin, PatternMethod::automatic);
    const auto s = reference.sample(0, {48, 36});
    const double z = (twin.projector->T_proj_world * s.point_world_mm).z();
    // aperture radius 7.5 mm; the spot's radius at depth z, then in px of the projector's image
    const double radius_px = 7.5 * std::abs(z - focus_mm) / focus_mm / z * 1700.15;
    ASSERT_GT(radius_px, 1.0);
    const auto contrast = [&](const render::RenderedCamera& r, std::size_t pitch) {
      const auto& i = r.irradiance;
      return std::hypot(i[4 * pitch](48, 36) - i[4 * pitch + 2](48, 36),
                        i[4 * pitch + 1](48, 36) - i[4 * pitch + 3](48, 36));
    };
    for (std::size_t pitch = 0; pitch < 3; ++pitch) {
      const double x = 2.0 * pi * radius_px / (13.0 + static_cast<double>(pitch));
      EXPECT_NEAR(contrast(soft, pitch) / contrast(sharp, pitch),
                  std::abs(2.0 * std::cyl_bessel_j(1.0, x) / x), 2e-6)
          << "focus " << focus_mm << " radius " << radius_px << " px, pitch " << pitch;
    }
  }
}

TEST(ProjectorDefocus, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  expect_agreement(twin, "defocus", 200, 5);
  twin.projector->blur_px = 0.9;
  twin.projector->response = gamma(2.2);
  expect_agreement(twin, "defocus, blur and gamma", 200, 5);
  twin = window(physical_sphere());
  twin.projector->optics = Optics{1.4, 16.0, 275.0};  // through the focus
  expect_agreement(twin, "defocus on a sphere", 200, 5);
}

// A response with kinks has no short series: each step by quadrature over the disk.
TEST(ProjectorDefocus, OfAResponseWithKinks) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  twin.projector->response = table();
  ASSERT_TRUE(render::choose_series(twin)[0][0].a.empty());
  expect_agreement_point_by_point(twin, "defocus and table", kGrayLimit);
}

TEST(ProjectorDefocus, OfGrayCode) {
  REQUIRE_RENDERER();
  Twin twin = gray_window();
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  expect_agreement_point_by_point(twin, "defocused code", kGrayLimit);
  twin.projector->optics = Optics{1.0, 30.0, 220.0};  // spots wider than a code word
  expect_agreement_point_by_point(twin, "strongly defocused code", kGrayLimit);
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  twin.projector->blur_px = 0.7;
  expect_agreement_point_by_point(twin, "defocused and blurred code", kGrayLimit);
}

TEST(ProjectorDefocus, OffChangesNothingAndAPinholeNextToNothing) {
  REQUIRE_RENDERER();
  Twin twin = gray_window();
  twin.fringes.steps = 4;
  const auto off = render_with(twin, PatternMethod::automatic);
  expect_same_bits(off, render_with(twin, PatternMethod::harmonics));
  twin.projector->optics = Optics{1e9, 16.0, 240.0};
  const auto pinhole = render_with(twin, PatternMethod::automatic);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t p = 0; p < off.irradiance[i].size(); ++p)
      ASSERT_NEAR(pinhole.irradiance[i].data[p], off.irradiance[i].data[p], 1e-5);
}

// ---------------------------------------------------------------- pixels

/// Projector pixels of 2.4 mm on the surface, 19 camera pixels each.
Twin coarse_projector() {
  Twin twin = window(frontal_plane());
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {125.0, 125.0, 63.3, 39.8}, {128, 80}, "coarse projector");
  return twin;
}

TEST(ProjectorPixels, ShowTheFrameBuffersValueAtTheirCentre) {
  REQUIRE_RENDERER();
  for (const std::optional<int> bits : {std::optional<int>{}, std::optional<int>{8}, std::optional<int>{3}}) {
    Twin twin = coarse_projector();
    twin.projector->pixel_structure = true;
    twin.projector->quantise_bits = bits;
    const auto r = render_with(twin, PatternMethod::automatic);
    const render::Reference reference(twin);
    const auto sequence = expand_sequence(twin.fringes);
    const double levels = bits ? std::exp2(*bits) - 1.0 : 0.0;
    int checked = 0;
    for (const auto& p : reference_block(reference, 0, whole_image(twin, 0, 4), {.gauss_n = 2})) {
      if (!p.interior) continue;
      const auto a = reference.sample(0, {p.x - 0.5, p.y}), b = reference.sample(0, {p.x + 0.5, p.y});
      const double pixel = std::round(a.projector_px.x());
      if (std::round(b.projector_px.x()) != pixel) continue;
      ++checked;
      for (std::size_t i = 0; i < sequence.size(); ++i) {
        double value = pattern_value(twin.fringes, sequence[i], pixel);
        if (bits) value = std::round(value * levels) / levels;
        EXPECT_NEAR(r.irradiance[i](p.x, p.y), value * p.pixel.mean, 2e-5);
      }
    }
    EXPECT_GT(checked, 100);
  }
}

TEST(ProjectorPixels, AgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  const auto smooth = render_with(twin, PatternMethod::automatic);
  twin.projector->pixel_structure = true;
  EXPECT_GT(largest_difference(smooth, render_with(twin, PatternMethod::automatic)), 0.1);
  expect_agreement_point_by_point(twin, "pixels", 3e-4);
  twin.projector->quantise_bits = 8;
  twin.projector->response = gamma(2.2);
  expect_agreement_point_by_point(twin, "pixels of 8 bits, gamma", 3e-4);
  twin.projector->blur_px = 0.6;
  expect_agreement_point_by_point(twin, "blurred pixels", kGrayLimit);
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  expect_agreement_point_by_point(twin, "blurred and defocused pixels", kGrayLimit);
  twin.projector->blur_px = 0.0;
  expect_agreement_point_by_point(twin, "defocused pixels", kGrayLimit);
}

TEST(ProjectorPixels, GrayCodeKeepsToTheRaster) {
  REQUIRE_RENDERER();
  Twin twin = gray_window();
  twin.fringes.directions[0].pitches_px = {20.5};  // edges inside pixels
  twin.projector->pixel_structure = true;
  expect_agreement_point_by_point(twin, "code of pixels", 3e-4);
}

TEST(ProjectorPixels, GapsKeepTheMeanAndAgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = coarse_projector();
  const auto mean_light = [](const Twin& t) {
    const auto transport = shared_renderer()->trace(t, 0, {Sampler::gauss, 256});
    double sum = 0.0;
    // 76x72 camera pixels are about 4x4 projector pixels
    for (int y = 0; y < 72; ++y)
      for (int x = 10; x < 86; ++x) sum += transport.mean(x, y);
    return sum;
  };
  const double full = mean_light(twin);
  twin.projector->pixel_structure = true;
  EXPECT_EQ(mean_light(twin), full);
  twin.projector->pixel_fill = 0.8;
  EXPECT_NEAR(mean_light(twin) / full, 1.0, 0.02);  // the window is four pixels but for some percent
  expect_agreement_point_by_point(twin, "gaps", 3e-4);
  twin.projector->blur_px = 0.1;
  expect_agreement_point_by_point(twin, "blurred gaps", kGrayLimit);
  EXPECT_NEAR(mean_light(twin) / full, 1.0, 0.02);
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  EXPECT_THROW(render_with(twin, PatternMethod::automatic), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::projector_test
