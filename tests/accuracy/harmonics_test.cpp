// SPDX-License-Identifier: Apache-2.0
// Fringes that are no sinusoids of their own: harmonics that are added to the light, waveforms, and a blur
// that varies over the projector's image. Against the reference (which convolves and sums where the renderer
// has Fourier series and tables), against plain formulas, and off without a trace.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|----------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                   |
// | 5e-5      | full scale rms | as for the shapes; smooth patterns                                    |
// | 1e-5      | of fundamental | bound of the dropped harmonics: a tenth of phase_error_rad            |
// | 3e-4      | full scale rms | patterns with edges, both sides at the same sample points: some fall   |
// |           |                | on the other side of an edge by rounding (projector_test.cpp)          |
// | 2e-3      | full scale rms | a sharp edge, 1/4096 of a period wide in its table: 5e-4 of the points lie |
// |           |                | in one, 0.3 of the light off; 16 points a pixel: 1.6e-3               |
// | 1e-5      | of the light   | phase in fp32, 5e-5 rad, times the sum of order times amplitude, 0.1   |
// | 2e-6      | relative       | attenuation against its formula, fp32; 2 ulp of an irradiance of 10    |
// | 1e-4      | full scale     | required of formed harmonics, of any pixel                            |
// | 0         |                | off = bitwise the same image                                          |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "render/pattern/form_images.hpp"
#include "render/pattern/response_series.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/tilted_window.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::harmonics_test {
namespace {

using render::PatternMethod;
constexpr double pi = std::numbers::pi;

/// Those of a real projector, orders 2 to 6 (fraction of full scale), mostly in quadrature with the fringe.
const Harmonics kHarmonics{
    {0.004, -0.011}, {-0.003, 0.008}, {0.001, 0.005}, {0.002, -0.003}, {-0.001, 0.002}};

Twin window(const Eigen::Vector3d& at_mm = {0, 0, 290}) { return tilted_window(12, at_mm); }

Twin with_harmonics(Twin twin, const Harmonics& harmonics = kHarmonics) {
  for (DirectionFringes& d : twin.fringes.directions) d.harmonics.assign(d.pitches_px.size(), harmonics);
  return twin;
}

Twin with_contrast(Twin twin, const std::vector<double>& contrast) {
  for (DirectionFringes& d : twin.fringes.directions) d.contrast = contrast;
  return twin;
}

Twin with_axis(Twin twin, Axis axis) {
  twin.fringes.directions[0].axis = axis;
  return twin;
}

Twin with_waveform(Twin twin, Waveform::Kind kind, const std::vector<double>& values) {
  twin.fringes.waveform = {kind, values};
  return twin;
}
Twin binary(Twin twin) {
  return with_waveform(std::move(twin), Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0});
}

render::RenderedCamera render_with(const Twin& twin, PatternMethod method) {
  shared_renderer()->set_tuning({.pattern_method = method});
  auto out = render_fixed(twin);
  shared_renderer()->set_tuning({});
  return out;
}

/// Both at the same 4x4 points of each pixel: no quadrature error between them.
void expect_agreement_point_by_point(const Twin& twin, const std::string& what, double limit) {
  const Agreement a =
      agreement(twin, 0, {Sampler::gauss, 16}, whole_image(twin, 0, 5), Pixels::interior, {.gauss_n = 4});
  std::cout << what << ": " << a.text() << "\n";
  EXPECT_GE(a.n, 100) << what;
  EXPECT_LE(a.gray_rms, limit) << what;
}

// ---------------------------------------------------------------- off

TEST(FringeHarmonics, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  for (const double blur_px : {0.0, 1.2}) {
    twin.projector->blur_px = blur_px;
    expect_same_bits(twin, with_harmonics(twin, {}));
    expect_same_bits(twin, with_harmonics(twin, {{0.0, 0.0}, {0.0, 0.0}}));
  }
  // the adaptive trace, too, and its estimate
  const auto off = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const auto zero =
      shared_renderer()->render(with_harmonics(twin, {{0.0, 0.0}}), 0, render::choose_sampling(twin));
  EXPECT_EQ(zero.sampling.sampler, Sampler::adaptive);
  expect_same_bits(off, zero);
}

TEST(FringeContrast, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  for (const double blur_px : {0.0, 1.2}) {
    twin.projector->blur_px = blur_px;
    expect_same_bits(twin, with_contrast(twin, {1.0, 1.0, 1.0}));
    expect_same_bits(with_harmonics(twin), with_contrast(with_harmonics(twin), {1.0, 1.0, 1.0}));
  }
}

// Each pitch its own, over all ways a fringe is carried: cosines, harmonics formed and summed up, steps
// evaluated one by one behind a response, pixels, binary fringes with and without blur.
TEST(FringeContrast, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  const std::vector<double> contrast{1.0, 0.7, 0.9};
  const Twin plain = with_contrast(window(), contrast);
  expect_agreement(plain, "contrast", 50, 7);
  expect_agreement(with_harmonics(plain), "contrast, harmonics", 50, 7);
  Twin bent = with_harmonics(plain);
  bent.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(bent, "contrast, harmonics, gamma", 50, 7);
  bent.projector->blur_px = 1.2;
  expect_agreement(bent, "contrast, harmonics, gamma, blur", 50, 7);
  Twin pixels = plain;
  pixels.projector->pixel_structure = true;
  expect_agreement_point_by_point(pixels, "contrast, pixels", 3e-4);
  Twin blurred = binary(plain);
  blurred.projector->blur_px = 1.2;
  expect_agreement(blurred, "contrast, binary, blur", 50, 7);
}

// ---------------------------------------------------------------- harmonics

TEST(FringeHarmonics, AreAddedAtThePhaseOfTheStep) {
  REQUIRE_RENDERER();
  const Twin without = window(), twin = with_harmonics(without);
  const render::Sampling one_ray{Sampler::gauss, 1};
  const auto with = shared_renderer()->render(twin, 0, one_ray);
  const auto plain = shared_renderer()->render(without, 0, one_ray);
  const render::Reference reference(without);
  const auto sequence = expand_sequence(twin.fringes);
  double largest = 0.0;
  for (int x = 4; x < 80; x += 9) {
    const auto s = reference.sample(0, {static_cast<double>(x), 30.0});
    ASSERT_TRUE(s.lit);
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const double t = 2.0 * pi *
                       (s.projector_px.x() / twin.fringes.directions[0].pitches_px[sequence[i].pitch] +
                        sequence[i].step / 12.0);
      double added = 0.0;
      for (int k = 2; k <= 6; ++k)
        added += kHarmonics[k - 2].cosine * std::cos(k * t) + kHarmonics[k - 2].sine * std::sin(k * t);
      const double more = with.irradiance[i](x, 30) - plain.irradiance[i](x, 30);
      EXPECT_NEAR(more, s.weight * added, 1e-5 * s.weight);
      largest = std::max(largest, std::abs(more) / s.weight);
    }
  }
  EXPECT_GT(largest, 0.015);
}

TEST(FringeHarmonics, AgreeWithTheReferenceOnTheAxisAndAtTheCorners) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y})
    for (const Eigen::Vector3d& at_mm :
         {Eigen::Vector3d(0, 0, 290), {-60, -45, 290}, {60, -45, 290}, {-60, 45, 290}, {60, 35, 290}}) {
      Twin twin = with_harmonics(with_axis(window(at_mm), axis));
      const std::string where = fmt::format("{} at {}, {}", axis_name(axis), at_mm.x(), at_mm.y());
      expect_agreement(twin, where, 50, 7);
      twin.projector->blur_px = 1.2;
      expect_agreement(twin, where + ", blur", 50, 7);
    }
}

TEST(FringeHarmonics, AgreeWithTheReferenceThroughTheProjector) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y}) {
    Twin twin = with_harmonics(with_axis(window(), axis));
    twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
    expect_agreement(twin, "harmonics and gamma", 100, 6);
    twin.projector->response = {};
    twin.projector->optics = Optics{2.0, 16.0, 240.0};
    expect_agreement(twin, "harmonics and defocus", 100, 6);
    twin.projector->optics.reset();
    twin.projector->pixel_structure = true;
    twin.projector->quantise_bits = 8;
    expect_agreement_point_by_point(twin, "harmonics of pixels", 3e-4);
    twin.projector->blur_px = 0.6;
    expect_agreement_point_by_point(twin, "harmonics of blurred pixels", kGrayLimit);
  }
}

/// Both parts of orders 2 to 4 differ all over the projector's image by as much as a real one's do.
Twin with_field(Twin twin) {
  for (DirectionFringes& d : twin.fringes.directions)
    d.harmonics_field = {{{0.01, -0.005}, {0.0, 0.012}, {-0.02, 0.01}},
                         {{-0.006, 0.0}, {0.01, 0.004}},
                         {{0.004, 0.008}, {}, {0.0, 0.006}},
                         {{0.005, 0.0}},
                         {{0.0, -0.004}, {0.003, 0.0}}};
  return twin;
}

TEST(HarmonicsField, OffChangesNoBit) {
  REQUIRE_RENDERER();
  const Twin twin = with_harmonics(window());
  Twin zero = twin;
  zero.fringes.directions[0].harmonics_field.assign(5, {{0.0, 0.0}});
  expect_same_bits(twin, zero);
}

// On the axis and at the corners, beside harmonics and without, formed and summed up, through blur, halo,
// response, a contrast of their own, defocus and a blur that varies.
TEST(HarmonicsField, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y})
    for (const Eigen::Vector3d& at_mm : {Eigen::Vector3d(0, 0, 290), {-60, -45, 290}, {60, 35, 290}}) {
      Twin twin = with_field(with_axis(window(at_mm), axis));
      const std::string where = fmt::format("field, {} at {}, {}", axis_name(axis), at_mm.x(), at_mm.y());
      expect_agreement(twin, where, 50, 7);
      twin = with_harmonics(std::move(twin));
      twin.projector->blur_px = 1.2;
      expect_agreement(twin, where + ", harmonics, blur", 50, 7);
    }
  const Twin corner = with_harmonics(with_field(window({-60, -45, 290})));
  expect_agreement(with_contrast(corner, {1.0, 0.7, 0.9}), "field, contrast", 50, 7);
  Twin twin = corner;
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(twin, "field, gamma", 50, 7);
  twin = corner;
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  expect_agreement(twin, "field, defocus", 100, 6);
  twin = corner;
  twin.projector->blur_px = 1.2;
  twin.projector->blur_field_px2 = {0.3, 0.1, 0.2, 0.0, 0.1};
  expect_agreement(twin, "field, blur field", 50, 7);
  twin.projector->blur_field_px2 = {};
  twin.projector->halo = {{.share = 0.2, .sigma_px = 5.0}};
  expect_agreement(twin, "field, halo", 50, 7);
}

// Far from what they are in the middle: the field itself is what is compared.
TEST(HarmonicsField, ChangesTheLightByItsPlace) {
  REQUIRE_RENDERER();
  Twin twin = window({60, 35, 290});
  twin.fringes.directions[0].harmonics_field = {{{0.02, 0.0}}, {}, {}, {{0.0, 0.01}}, {}};
  Twin without = twin;
  without.fringes.directions[0].harmonics_field.clear();
  const render::Sampling one_ray{Sampler::gauss, 1};
  const auto with = shared_renderer()->render(twin, 0, one_ray),
             plain = shared_renderer()->render(without, 0, one_ray);
  const render::Reference reference(without);
  const auto sequence = expand_sequence(twin.fringes);
  for (int x = 4; x < 80; x += 9) {
    const auto s = reference.sample(0, {static_cast<double>(x), 30.0});
    ASSERT_TRUE(s.lit);
    const Lens& lens = twin.projector->lens;
    const double u = 2.0 * (s.projector_px.x() + 0.5) / lens.width() - 1.0,
                 v = 2.0 * (s.projector_px.y() + 0.5) / lens.height() - 1.0;
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const double t = 2.0 * pi *
                       (s.projector_px.x() / twin.fringes.directions[0].pitches_px[sequence[i].pitch] +
                        sequence[i].step / 12.0);
      const double added = 0.02 * u * std::cos(2 * t) + 0.01 * u * v * std::sin(2 * t),
                   more = with.irradiance[i](x, 30) - plain.irradiance[i](x, 30);
      EXPECT_NEAR(more, s.weight * added, 1e-5 * s.weight);
    }
  }
}

TEST(HarmonicsField, IsRefusedWhereThePlaceDoesNotTellTheLight) {
  REQUIRE_RENDERER();
  Twin bounces = with_field(window());
  bounces.render.bounces = 1;
  EXPECT_THROW(render_fixed(bounces), UserError);
  Twin pixels = with_field(window());
  pixels.projector->pixel_structure = true;
  EXPECT_THROW(render_fixed(pixels), UserError);
}

TEST(FringeHarmonics, ArePitchesOwn) {
  REQUIRE_RENDERER();
  const Twin without = window();
  Twin twin = without;
  twin.fringes.directions[0].harmonics = {{}, kHarmonics, {{0.02, 0.0}}};
  expect_agreement(twin, "of two pitches", 100, 6);
  const auto with = render_with(twin, PatternMethod::harmonics),
             plain = render_with(without, PatternMethod::harmonics);
  // another shader variant may round differently: 2 ulp of 10
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t k = 0; k < with.irradiance[i].size(); ++k)
      ASSERT_NEAR(with.irradiance[i].data[k], plain.irradiance[i].data[k], 2e-6);
  EXPECT_NE(with.irradiance[12].data, plain.irradiance[12].data);
  EXPECT_NE(with.irradiance[24].data, plain.irradiance[24].data);
}

TEST(FringeHarmonics, EqualTheStepsEvaluatedOneByOne) {
  REQUIRE_RENDERER();
  for (const int steps : {4, 12}) {
    Twin twin = with_harmonics(window());
    twin.fringes.steps = steps;
    ASSERT_FALSE(render::choose_series(twin, PatternMethod::harmonics)[0][0].a.empty());
    const auto series = render_with(twin, PatternMethod::harmonics);
    const auto direct = render_with(twin, PatternMethod::direct);
    EXPECT_LE(largest_difference(series, direct), 10.0 * (1e-5 + 2e-6));  // E is up to 10
    const auto automatic = render_with(twin, PatternMethod::automatic);
    expect_same_bits(automatic, render::choose_series(twin)[0][0].a.empty() ? direct : series);
  }
}

// ---------------------------------------------------------------- harmonics from the fundamental

/// A ball before a wall, 5 % of the pixels on its outline and its shadow's.
Twin ball_before_wall() {
  Twin twin = only_camera(paper_rig(), 0);
  PlaneShape wall;
  wall.point_mm = {0, 0, 300};
  wall.normal = Eigen::Vector3d(0.1, 0, -1).normalized();
  twin.objects = {Object{"ball", SphereShape{{0, 0, 250}, 5.0}, {}}, Object{"wall", wall, {}}};
  return crop_around(std::move(twin), {-4, 0, 250}, 140, 100);
}

Twin with_gray_code(Twin twin, double pitch_px) {
  twin.fringes.steps = 12;
  twin.fringes.directions[0] = {Axis::x, {pitch_px}, {0.0}, GrayCode{.bits = 6}};
  twin.fringes.unwrap = Unwrap::gray;
  return twin;
}

std::size_t own_pixels(const Twin& twin) {
  const auto transport = shared_renderer()->trace(twin, 0, render::choose_sampling(twin));
  EXPECT_TRUE(transport.harmonics[0][0].empty());
  return transport.own_harmonics[0][0].places.size();
}

// By the adaptive trace and by a fixed rule, with few steps (which confuse orders) and with many.
TEST(FringeHarmonics, FormedOnesAgreeWithTheReference) {
  REQUIRE_RENDERER();
  for (const int steps : {4, 12}) {
    Twin twin = with_harmonics(window());
    twin.fringes.steps = steps;
    EXPECT_LT(own_pixels(twin), 800u);  // of 4800, those on the border of the image among them
    expect_agreement(twin, fmt::format("formed, {} steps", steps), 100, 6);
  }
  Twin twin = with_harmonics(with_gray_code(window(), 20.0));
  EXPECT_LT(own_pixels(twin), 100u);
  const render::RenderedCamera formed = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  EXPECT_EQ(formed.sampling.sampler, Sampler::gauss);
  const render::Reference reference(twin);
  double squares = 0.0, n = 0.0;
  for (int y = 3; y < 60; y += 9)
    for (int x = 3; x < 80; x += 9) {
      const auto truth = reference.pixel(0, x, y, {.gauss_n = 8});
      for (std::size_t i = 0; i < 12; ++i, ++n)
        squares += std::pow(formed.irradiance[i](x, y) - truth.irradiance[i], 2);
    }
  const Sensor& sensor = twin.cameras[0].sensor;
  const double rms = std::sqrt(squares / n) * sensor.gain_dn / sensor.max_dn();
  std::cout << "formed, beside Gray code: " << rms << " of full scale\n";
  EXPECT_LE(rms, kGrayLimit);
}

// At edges the sums are the pixel's own: the same as where the same rule sums up every harmonic everywhere.
TEST(FringeHarmonics, EdgesHaveSumsOfTheirOwn) {
  REQUIRE_RENDERER();
  const Twin twin = with_harmonics(with_gray_code(ball_before_wall(), 40.0));
  const auto formed = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const auto summed = shared_renderer()->render(twin, 0, {Sampler::gauss, formed.sampling.samples});
  EXPECT_GT(own_pixels(twin), 100u);
  EXPECT_LT(own_pixels(twin), 3500u);
  const Sensor& sensor = twin.cameras[0].sensor;
  EXPECT_LE(largest_difference(formed, summed) * sensor.gain_dn / sensor.max_dn(), 1e-4);
}

// A harmonic that the blur takes away is not carried.
TEST(FringeHarmonics, AsManyAreCarriedAsShow) {
  Twin twin = with_harmonics(window());
  EXPECT_EQ(render::choose_series(twin, PatternMethod::harmonics)[0][0].a.size(), 7u);
  twin.projector->blur_px = 1.4;  // at pitch 13 harmonic 6 keeps 2.6e-4 of 2e-3
  EXPECT_EQ(render::choose_series(twin, PatternMethod::harmonics)[0][0].a.size(), 6u);
  EXPECT_FALSE(render::holds_any_steps(twin));
  EXPECT_TRUE(render::holds_any_steps(window()));
}

// ---------------------------------------------------------------- waveforms

TEST(FringeWaveform, BlurredBinaryFringesAgreeWithTheReference) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y})
    for (const double blur_px : {0.5, 1.0, 2.0, 3.0}) {
      Twin twin = binary(with_axis(window(), axis));
      twin.projector->blur_px = blur_px;
      expect_agreement_point_by_point(twin, fmt::format("binary {}, blur {} px", axis_name(axis), blur_px),
                                      kGrayLimit);
    }
  // the whole pixel by the sampling that the renderer chooses
  Twin twin = binary(window());
  twin.projector->blur_px = 1.0;
  expect_agreement(twin, "binary, blur 1 px, chosen sampling", 100, 6);
}

TEST(FringeWaveform, SharpBinaryFringesAndPixelsAgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = binary(window());
  twin.fringes.directions[0].phase_origin_px = {0.3, -1.2, 0.0};  // edges anywhere
  expect_agreement_point_by_point(twin, "sharp binary", 2e-3);
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement_point_by_point(twin, "sharp binary, gamma", 2e-3);
  twin.projector->pixel_structure = true;
  expect_agreement_point_by_point(twin, "binary pixels", 3e-4);
  twin.projector->blur_px = 0.7;
  expect_agreement_point_by_point(twin, "blurred binary pixels", kGrayLimit);
}

TEST(FringeWaveform, TablesAgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = with_waveform(window(), Waveform::Kind::table, {1.0, 0.9, 0.2, 0.1, 0.0, 0.3, 0.7});
  expect_agreement_point_by_point(twin, "table", kGrayLimit);
  twin.projector->blur_px = 0.8;
  expect_agreement_point_by_point(twin, "blurred table", kGrayLimit);
  twin = with_harmonics(twin);
  expect_agreement_point_by_point(twin, "blurred table with harmonics", kGrayLimit);
  twin.projector->response = {ProjectorResponse::Kind::gamma, 1.8, {}};
  expect_agreement_point_by_point(twin, "blurred table, gamma", kGrayLimit);
}

TEST(FringeWaveform, DefocusedBinaryFringesAgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = binary(window());
  twin.projector->blur_px = 0.9;
  twin.projector->optics = Optics{2.0, 16.0, 240.0};
  expect_agreement_point_by_point(twin, "defocused and blurred binary", kGrayLimit);
}

// With steps enough a blurred binary fringe is a short series, which one trace holds.
TEST(FringeWaveform, BlurDecidesHowItIsCarried) {
  Twin twin = binary(window());
  EXPECT_TRUE(render::choose_series(twin, PatternMethod::harmonics)[0][0].a.empty());
  twin.projector->blur_px = 2.0;
  const auto series = render::choose_series(twin, PatternMethod::harmonics)[0][0];
  ASSERT_FALSE(series.a.empty());
  // a square wave: 2/pi (cos t - cos 3t / 3 + ...) times the amplitude 1/2, no sines, no even orders
  EXPECT_NEAR(series.a[0], 0.5, 1e-14);
  EXPECT_NEAR(series.a[1], 2.0 / pi, 1e-14);
  EXPECT_NEAR(series.a[2], 0.0, 1e-14);
  EXPECT_NEAR(series.a[3], -2.0 / (3.0 * pi), 1e-14);
  for (const double b : series.b) EXPECT_NEAR(b, 0.0, 1e-14);
}

// ---------------------------------------------------------------- blur that varies over the image

/// From 1.0 px in the middle to 1.9 px in a corner.
Twin with_blur_field(Twin twin) {
  twin.projector->blur_px = 1.0;
  twin.projector->blur_field_px2 = {0.1, -0.2, 1.2, 0.3, 0.9};
  return twin;
}

TEST(BlurField, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  twin.projector->blur_px = 1.2;
  const auto before = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  twin.projector->blur_field_px2 = {0.0, 0.0, 0.0, 0.0, 0.0};
  const auto after = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  EXPECT_EQ(after.sampling.sampler, Sampler::adaptive);
  expect_same_bits(before, after);
}

TEST(BlurField, TakesContrastByItsVariance) {
  REQUIRE_RENDERER();
  const render::Sampling one_ray{Sampler::gauss, 1};
  for (const Eigen::Vector3d& at_mm : {Eigen::Vector3d(0, 0, 290), {-60, -45, 290}, {60, 35, 290}}) {
    const Twin sharp = window(at_mm);
    Twin soft = with_blur_field(sharp);
    const auto s = render::Reference(sharp).sample(0, {40.0, 30.0});
    ASSERT_TRUE(s.lit);
    const double u = (s.projector_px.x() + 0.5) / 640.0 - 1.0, v = (s.projector_px.y() + 0.5) / 360.0 - 1.0;
    const double variance = 1.0 + 0.1 * u - 0.2 * v + 1.2 * u * u + 0.3 * u * v + 0.9 * v * v;
    const auto a = shared_renderer()->trace(sharp, 0, one_ray),
               b = shared_renderer()->trace(soft, 0, one_ray);
    for (std::size_t p = 0; p < 3; ++p) {
      const auto contrast = [&](const render::Transport& t) {
        return std::hypot(t.cosine[0][p](40, 30), t.sine[0][p](40, 30)) / t.mean(40, 30);
      };
      const double wave = 2.0 * pi / (13.0 + static_cast<double>(p));
      EXPECT_NEAR(contrast(b) / contrast(a), std::exp(-0.5 * wave * wave * variance), 2e-6);
    }
  }
}

TEST(BlurField, AgreesWithTheReferenceOnTheAxisAndAtTheCorners) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y})
    for (const Eigen::Vector3d& at_mm : {Eigen::Vector3d(0, 0, 290), {-60, -45, 290}, {60, 35, 290}}) {
      Twin twin = with_blur_field(with_axis(window(at_mm), axis));
      const std::string where =
          fmt::format("blur field, {} at {}, {}", axis_name(axis), at_mm.x(), at_mm.y());
      expect_agreement(twin, where, 50, 7);
      expect_agreement(with_harmonics(twin), where + ", harmonics", 50, 7);
      expect_agreement_point_by_point(binary(twin), where + ", binary", kGrayLimit);
    }
}

TEST(BlurField, OfGrayCodeAndWhereThereIsNone) {
  REQUIRE_RENDERER();
  Twin twin = with_blur_field(window({60, 35, 290}));
  twin.fringes.directions[0] = {Axis::x, {40.0}, {-0.5}, GrayCode{.bits = 5, .complementary = true}};
  twin.fringes.unwrap = Unwrap::gray;
  expect_agreement_point_by_point(twin, "blur field, Gray code", 3e-4);
  twin.fringes.directions[0].pitches_px = {2.0};  // its edges overlap
  EXPECT_THROW(render_fixed(twin), UserError);
  twin = with_blur_field(window());
  twin.projector->pixel_structure = true;
  EXPECT_THROW(render_fixed(twin), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::harmonics_test
