// SPDX-License-Identifier: Apache-2.0
// Waves of the raster. Against the reference, which samples frequencies where the renderer traces fringes of
// their own; against pixels of one level each, summed up one by one; off without a trace.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes                                                    |
// | 2e-6      | of the light   | single precision: sums of 3 terms, 6e-8 each, factors rounded before |
// | 3e-5      | of the light   | phase in fp32 (5e-5 rad at 13 px, at 3 px five times), times the     |
// |           |                | amplitudes, 0.1                                                      |
// | 0         |                | off = bitwise the same image                                         |
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/tilted_window.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::raster_test {
namespace {

constexpr double pi = std::numbers::pi;

Twin seen_at(const Eigen::Vector3d& at_mm = {0, 0, 290}) { return tilted_window(6, at_mm); }

/// Orders 8 ... 10: of 13 px and more about 3 px long, one of them forwards where the raster is coarse.
Twin with_raster(Twin twin, double pitch_px = 1.0037) {
  for (DirectionFringes& d : twin.fringes.directions)
    d.raster = {pitch_px, 8, {{0.012, -0.005}, {0.0, 0.0}, {-0.004, 0.02}}};
  return twin;
}

TEST(Raster, OffChangesNoBit) {
  REQUIRE_RENDERER();
  const Twin twin = seen_at();
  Twin zero = with_raster(twin);
  zero.fringes.directions[0].raster.waves = {{0.0, 0.0}};
  expect_same_bits(twin, zero);
}

TEST(Raster, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  for (const Axis axis : {Axis::x, Axis::y}) {
    Twin twin = with_raster(seen_at());
    twin.fringes.directions[0].axis = axis;
    expect_agreement(twin, "waves", 50, 7);
    twin = with_raster(seen_at({-60, -45, 290}), 1.4);
    twin.fringes.directions[0].axis = axis;
    twin.fringes.directions[0].harmonics.assign(3, {{0.004, -0.011}, {-0.003, 0.008}});
    twin.projector->blur_px = 0.6;
    for (std::size_t i = 0; i < 18; ++i)
      twin.projector->image_shifts_px.push_back(0.3 * std::sin(static_cast<double>(i)));
    expect_agreement(twin, "waves, harmonics, blur, shifts", 50, 7);
  }
  const Twin corner = with_raster(seen_at({60, 35, 290}));
  Twin twin = corner;
  twin.fringes.directions[0].contrast = {1.0, 0.7, 0.9};
  twin.projector->blur_px = 0.6;
  twin.projector->halo = {{.share = 0.2, .sigma_px = 0.5}};
  expect_agreement(twin, "waves, contrast, halo", 50, 7);
  twin = corner;
  twin.fringes.directions[0].pitches_px = {16.0, 13.0,
                                           14.0};  // of 16 the first order is half a turn per pixel
  twin.fringes.directions[0].raster.pitch_px = 1.0;
  expect_agreement(twin, "waves, half a turn per pixel", 50, 7);
  twin = corner;
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(twin, "waves, gamma", 50, 7);
  twin = corner;
  twin.projector->optics = Optics{2.0, 16.0, 280.0};
  expect_agreement(twin, "waves, defocus", 100, 6);
  twin = corner;
  twin.projector->blur_px = 0.6;
  twin.projector->blur_field_px2 = {0.05, -0.02, 0.0, 0.03, 0.0};
  expect_agreement(twin, "waves, blur that varies", 50, 7);
}

/// The waves of an image must be those of the plain formula at single rays, with its light and on top of
/// steps that are evaluated directly as well.
void expect_formula(Twin without, const std::string& what) {
  for (std::size_t i = 0; i < 18; ++i)
    without.projector->light_factors.push_back(1.0 + 0.05 * std::cos(static_cast<double>(i)));
  const Twin twin = with_raster(without);
  const render::Sampling one_ray{Sampler::gauss, 1};
  const auto with = shared_renderer()->render(twin, 0, one_ray),
             plain = shared_renderer()->render(without, 0, one_ray);
  const render::Reference reference(without);
  const auto sequence = expand_sequence(twin.fringes);
  for (const std::size_t image : {0U, 8U, 17U}) {
    const PatternSpec& spec = sequence[image];
    const double pitch_px = twin.fringes.directions[0].pitches_px[static_cast<std::size_t>(spec.pitch)],
                 origin_px = twin.fringes.directions[0].phase_origin_px[static_cast<std::size_t>(spec.pitch)];
    for (int x = 4; x < 80; x += 9) {
      const auto s = reference.sample(0, {static_cast<double>(x), 30.0});
      ASSERT_TRUE(s.lit);
      double light = 0.0;
      for (int k = 0; k < 3; ++k) {
        const Harmonic& wave = twin.fringes.directions[0].raster.waves[static_cast<std::size_t>(k)];
        const double x_px = s.projector_px.x(), w = 2.0 * pi * ((8 + k) / pitch_px - 1.0 / 1.0037);
        const double t = 2.0 * pi *
                         ((8 + k) * ((x_px - origin_px) / pitch_px + spec.step / 6.0) -
                          (x_px - 640) / 1.0037),
                     square = std::sin(0.5 * 1.0037 * w) / (0.5 * 1.0037 * w);
        light += square * (wave.cosine * std::cos(t) + wave.sine * std::sin(t));
      }
      EXPECT_NEAR(with.irradiance[image](x, 30) - plain.irradiance[image](x, 30),
                  twin.projector->light_factors[image] * s.weight * light, 3e-5 * s.weight)
          << what << ' ' << image;
    }
  }
}

TEST(Raster, IsAddedByTheFormula) {
  REQUIRE_RENDERER();
  Twin twin = seen_at();
  twin.fringes.directions[0].phase_origin_px = {1.7, -0.4, 3.0};
  expect_formula(twin, "carried");
  twin.fringes.waveform = {Waveform::Kind::levels, {1.0, 1.0, 0.0, 0.0}};
  expect_formula(twin, "evaluated directly");
}

// Pixels show the level that order 8 of the fringe has in their middle. What a blurred square of them lights
// is summed up pixel by pixel; the wave has the share that a square and the blur leave of its frequency. What
// is left are the faster aliases.
TEST(Raster, IsWhatPixelsOfOneLevelMake) {
  constexpr double kPitchPx = 13.2, kRasterPx = 1.1, kSigmaPx = 0.9, kOriginPx = 0.3, kMiddlePx = 5.0;
  constexpr int kOrder = 8, kSteps = 5;
  const Raster raster{kRasterPx, kOrder, {{1.0, 0.0}}};
  ASSERT_EQ(raster.turns_taken(kOrder, kPitchPx), 1.0);
  const double per_px = kOrder / kPitchPx - 1.0 / kRasterPx;
  const auto left = [&](double f) {
    return raster.left_by_pixels(f) * std::exp(-2.0 * pi * pi * f * f * kSigmaPx * kSigmaPx);
  };
  const double faster =
      std::abs(left(per_px + 1.0 / kRasterPx)) + std::abs(left(per_px - 1.0 / kRasterPx)) + 1e-6;
  EXPECT_LT(faster, 0.01 * left(per_px));
  const auto cdf = [](double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); };
  for (int step = 0; step < kSteps; ++step)
    for (double x = 0.0; x < 14.0; x += 0.37) {
      double light = 0.0;
      for (int i = -20; i < 40; ++i) {
        const double middle = kMiddlePx + kRasterPx * i;
        const double level =
            std::cos(2.0 * pi * kOrder * ((middle - kOriginPx) / kPitchPx + step * 1.0 / kSteps));
        light += level * (cdf((x - middle + 0.5 * kRasterPx) / kSigmaPx) -
                          cdf((x - middle - 0.5 * kRasterPx) / kSigmaPx));
      }
      const double t =
          2.0 * pi *
          (kOrder * ((x - kOriginPx) / kPitchPx + step * 1.0 / kSteps) - (x - kMiddlePx) / kRasterPx);
      EXPECT_NEAR(light, left(per_px) * std::cos(t), faster);
    }
}

// Of two directions one has waves, seen over other surfaces, by objects that move and exposures that are
// late: what the images have more is what those of the other twin have more whose waves are twice as large,
// halved.
TEST(Raster, IsInProportionWhereLightTakesOtherWays) {
  REQUIRE_RENDERER();
  Twin twin = window_on_a_corner(0.8, 80, 60);
  twin.fringes.steps = 3;
  twin.fringes.directions.push_back(twin.fringes.directions[0]);
  twin.fringes.directions[1].axis = Axis::y;
  for (const char* way : {"bounces", "motion", "late exposures"}) {
    twin.render.bounces = way == std::string("bounces") ? 1 : 0;
    twin.objects[0].motion =
        way == std::string("motion") ? std::vector{0.3, 0.0, 0.2} : std::vector<double>{};
    if (way == std::string("late exposures")) twin.cameras[0].timing = ExposureTiming{.late = {0.1}};
    Twin one = twin, two = twin;
    one.fringes.directions[1].raster = {1.0037, 8, {{0.012, -0.005}, {0.0, 0.0}, {-0.004, 0.02}}};
    two.fringes.directions[1].raster = {1.0037, 8, {{0.024, -0.01}, {0.0, 0.0}, {-0.008, 0.04}}};
    const render::Sampling points{Sampler::gauss, 16};
    const auto none = shared_renderer()->render(twin, 0, points),
               once = shared_renderer()->render(one, 0, points),
               twice = shared_renderer()->render(two, 0, points);
    double most = 0.0;
    for (std::size_t i = 0; i < none.irradiance.size(); ++i)
      for (std::size_t k = 0; k < none.irradiance[i].size(); ++k) {
        const double more = once.irradiance[i].data[k] - none.irradiance[i].data[k];
        ASSERT_NEAR(twice.irradiance[i].data[k] - none.irradiance[i].data[k], 2.0 * more, 4e-6 * 60.0) << way;
        if (i < 8) {  // a late exposure of the ninth sees the tenth
          ASSERT_EQ(more, 0.0) << "the other direction";
        }
        most = std::max(most, std::abs(more));
      }
    EXPECT_GT(most, 0.1);
  }
}

TEST(Raster, IsRefusedWhereItHasNoTreatment) {
  REQUIRE_RENDERER();
  Twin pixels = with_raster(seen_at());
  pixels.projector->pixel_structure = true;
  EXPECT_THROW(render_fixed(pixels), UserError);
  Twin below = with_raster(seen_at());
  below.objects[0].material.mean_free_path_mm = 0.5;
  EXPECT_THROW(render_fixed(below), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::raster_test
