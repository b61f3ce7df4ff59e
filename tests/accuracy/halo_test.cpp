// SPDX-License-Identifier: Apache-2.0
// Light that the projector spreads further than its blur: against the reference, which convolves each part by
// itself, against the Fourier transform of the point spread, and off: no bit changes.
// | tolerance | unit           | origin |
// |-----------|----------------|-----------------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp) | | 5e-5      | full scale rms | as for
// the shapes                                                           | | 3e-4      | full scale rms | steps
// of the projector's pixels, point by point (harmonics_test.cpp)        | | 2e-4      | full scale rms | code
// images: edges of the table, as blurred ones (patterns_test.cpp)        | | 2e-6      | relative       |
// contrast in single precision (harmonics_test.cpp, blur field)               | | 0         | | off = bitwise
// the same image                                                |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "render/pattern/waveform.hpp"
#include "render/pattern/waveform_tables.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::halo_test {
namespace {

/// A near tail and a veil, as a real projector has them (datasets/kamino-procam-board).
const std::vector<Halo> kHalo{{.share = 0.2, .sigma_px = 1.7}, {.share = 0.1, .sigma_px = 38.0}};

Twin window() {
  Twin twin = with_object(left_window({0, 0, 290}, 80, 60), "plane", tilted_plane());
  twin.projector->blur_px = 0.6;
  return twin;
}
Twin with_halo(Twin twin, const std::vector<Halo>& halo = kHalo) {
  twin.projector->halo = halo;
  return twin;
}
Twin with_code(Twin twin) {
  twin.fringes.steps = 4;
  twin.fringes.directions[0] = {Axis::x, {4.0}, {-0.5}, GrayCode{.bits = 9, .complementary = true}};
  twin.fringes.unwrap = Unwrap::gray;
  return twin;
}

/// Rms difference of the images of a kind from the reference, of full scale, over whole pixels.
double code_error(const Twin& twin) {
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const render::Reference reference(twin);
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  double squares = 0.0, n = 0.0;
  for (int y = 4; y < 56; y += 8)
    for (int x = 4; x < 76; x += 8) {
      const auto truth = reference.pixel(0, x, y, {.gauss_n = 24});
      for (std::size_t i = 0; i < sequence.size(); ++i) {
        if (!sequence[i].is_gray()) continue;
        squares += std::pow(static_cast<double>(rendered.irradiance[i](x, y)) - truth.irradiance[i], 2);
        ++n;
      }
    }
  const Sensor& sensor = twin.cameras[0].sensor;
  return std::sqrt(squares / n) * sensor.gain_dn / sensor.max_dn();
}

TEST(Halo, OffChangesNoBit) {
  REQUIRE_RENDERER();
  for (const Twin& twin : {window(), with_code(window())})
    expect_same_bits(twin, with_halo(twin, {{.share = 0.3, .sigma_px = 0.0}}));
  expect_same_bits(window(), with_halo(window(), {{.share = 0.0, .sigma_px = 5.0}}));
  // a part without a share: edges of a code by a table, no longer in closed form over the pixel
  EXPECT_LT(code_error(with_halo(with_code(window()), {{.share = 0.0, .sigma_px = 5.0}})), 2e-4);
  // the adaptive trace, too, and its estimate
  const auto off = shared_renderer()->render(window(), 0, render::choose_sampling(window()));
  const auto zero = shared_renderer()->render(with_halo(window(), {{.share = 0.0, .sigma_px = 5.0}}), 0,
                                              render::choose_sampling(window()));
  EXPECT_EQ(zero.sampling.sampler, Sampler::adaptive);
  expect_same_bits(off, zero);
}

// exp(-2 (pi sigma f)^2) of each part: what is left of a wave of f cycles per px.
TEST(Halo, LeavesOfEachPitchWhatItsFourierTransformSays) {
  REQUIRE_RENDERER();
  const Twin with = with_halo(window());
  const auto steps = [](const Twin& twin) { return render_fixed(twin).irradiance; };
  const std::vector<ImageF> plain = steps(window()), spread = steps(with);
  const int n = with.fringes.steps;
  for (std::size_t p = 0; p < 3; ++p) {
    const auto amplitude = [&](const std::vector<ImageF>& images) {
      double cosine = 0.0, sine = 0.0;
      for (int k = 0; k < n; ++k) {
        const double at = 2.0 * std::numbers::pi * k / n,
                     value = images[p * static_cast<std::size_t>(n) + static_cast<std::size_t>(k)](40, 30);
        cosine += value * std::cos(at), sine += value * std::sin(at);
      }
      return std::hypot(cosine, sine);
    };
    const double f = 1.0 / with.fringes.directions[0].pitches_px[p];
    double left = 0.7;
    for (const Halo& h : kHalo)
      left += h.share * std::exp(-2.0 * std::pow(std::numbers::pi * h.sigma_px * f, 2));
    EXPECT_NEAR(amplitude(spread) / amplitude(plain), left, 2e-6) << p;
    EXPECT_NEAR(with.projector->halo_attenuation(f), left, 1e-14) << p;
    EXPECT_LT(left, 0.95) << p;
  }
}

// Over all ways in which fringes are carried: cosines, harmonics, steps one by one, pixels, binary fringes.
TEST(Halo, FringesAgreeWithTheReference) {
  REQUIRE_RENDERER();
  const Twin plain = with_halo(window());
  expect_agreement(plain, "halo", 50, 7);
  Twin harmonics = plain;
  harmonics.fringes.steps = 12;
  for (DirectionFringes& d : harmonics.fringes.directions)
    d.harmonics.assign(d.pitches_px.size(), {{0.004, -0.011}, {-0.003, 0.008}});
  expect_agreement(harmonics, "halo, harmonics", 50, 7);
  Twin bent = plain;
  bent.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(bent, "halo, gamma", 50, 7);
  Twin binary = plain;
  binary.fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
  expect_agreement(binary, "halo, binary", 50, 7);
  Twin varies = plain;
  varies.projector->blur_field_px2 = {0.1, -0.1, 0.3, 0.0, 0.2};
  expect_agreement(varies, "halo, blur that varies", 8, 21);  // convolved point by point: slow
  Twin pixels = plain;
  pixels.projector->pixel_structure = true;
  const Agreement a =
      agreement(pixels, 0, {Sampler::gauss, 16}, whole_image(pixels, 0, 5), Pixels::interior, {.gauss_n = 4});
  std::cout << "halo, pixels: " << a.text() << "\n";
  EXPECT_GE(a.n, 100);
  EXPECT_LE(a.gray_rms, 3e-4);
}

TEST(Halo, CodeAgreesWithTheReference) {
  REQUIRE_RENDERER();
  const double error = code_error(with_halo(with_code(window())));
  std::cout << "halo, code: " << error << " of full scale\n";
  EXPECT_LT(error, 2e-4);
  // and it is there: a tenth of the light is spread over many words
  const Twin code = with_code(window());
  EXPECT_GT(relative_change(render_fixed(code), render_fixed(with_halo(code))), 0.02);
}

// Two parts are what one of their common width is.
TEST(Halo, PartsAddUp) {
  const Twin twin = with_code(window());
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  double first_px = 0.0;
  const auto table = [&](const std::vector<Halo>& halo) {
    return render::axis_waveform(with_halo(twin, halo), sequence.back(), 100.0, &first_px);
  };
  const std::vector<float> one = table({{.share = 0.3, .sigma_px = 2.0}}),
                           two = table({{.share = 0.1, .sigma_px = 2.0}, {.share = 0.2, .sigma_px = 2.0}});
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(one[i], two[i], 2e-7) << i;
}

TEST(Halo, WithPatternImagesOrGapsIsRefused) {
  REQUIRE_RENDERER();
  Twin gaps = with_halo(window());
  gaps.projector->pixel_structure = true;
  gaps.projector->pixel_fill = 0.8;
  EXPECT_THROW(render_fixed(gaps), UserError);
  Twin varies = with_halo(with_code(window()));
  varies.projector->blur_field_px2 = {0.1, 0.0, 0.0, 0.0, 0.0};
  EXPECT_THROW(render_fixed(varies), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::halo_test
