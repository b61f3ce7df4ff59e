// SPDX-License-Identifier: Apache-2.0
// Everything that a twin can know of its fringes, planted into gray values by plain formulas, is taken out of
// some of the steps.
//
// | check               | tolerance | origin                                                              |
// |---------------------|-----------|---------------------------------------------------------------------|
// | gray values         | 2e-3 DN   | six passes leave 5 DN times a fifth six times, 3e-4; single         |
// |                     |           | precision of places of 500 px turns a wave of 4 px by 1e-4          |
// | of places off by    | 0.04 DN   | fields of 1.3 DN move by 2 * 5/720 of that, 0.02, which fits of six |
// | 8 and 5 px          |           | steps may double                                                    |
// | before              | > 1 DN    | planted                                                             |
#include "cosim/shape/known_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::cosim::known_light_test {
namespace {

constexpr double kPi = std::numbers::pi, kMeanDn = 100.0, kAmplitudeDn = 60.0, kBlackDn = 6.0;
constexpr int kWidth = 90, kHeight = 40, kSteps = 12;

/// 32 px per fringe of a direction, 24 of another, in 12 steps each.
Twin knowing_twin() {
  Twin twin = testing::paper_rig();
  twin.cameras.erase(twin.cameras.begin() + 1, twin.cameras.end());
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {900, 900, 45, 20}, {kWidth, kHeight}, "test");
  twin.cameras[0].sensor.black_level_dn = kBlackDn;
  twin.cameras[0].psf_px = 0.3;
  twin.projector->blur_px = 0.7;
  twin.fringes = {.directions = {{Axis::x, {32.0}, {1.5}, {}}, {Axis::y, {24.0}, {-2.0}, {}}},
                  .steps = kSteps,
                  .unwrap = Unwrap::none,
                  .mean = 0.5,
                  .amplitude = 0.4,
                  .images = {}};
  for (DirectionFringes& d : twin.fringes.directions) {
    d.harmonics = {{{0.01, -0.004}, {}, {0.0, 0.006}}};
    d.harmonics_field = {{{0.004, 0.0}}, {{0.0, 0.003}, {0.002, 0.0}}};
    d.raster = {1.07, 21, {{0.005, 0.0}, {0.0, -0.004}}};
  }
  twin.fringes.image_harmonics.assign(2 * kSteps, {});
  twin.fringes.image_harmonics[4] = {{-0.004, 0.002}, {0.003, 0.0}, {0.0, 0.002}};
  const double flicker[] = {1.01, 0.98}, exposure[] = {1.02, 0.97};  // and as much less: a mean of 1
  for (int i = 0; i < 2 * kSteps; ++i) {
    twin.projector->image_shifts_px.push_back(0.05 * std::sin(i));
    twin.projector->light_factors.push_back(i % 3 == 2 ? 1.0 / (flicker[0] * flicker[1]) : flicker[i % 3]);
    twin.cameras[0].exposure_factors.push_back(i / 4 % 3 == 2 ? 1.0 / (exposure[0] * exposure[1])
                                                              : exposure[i / 4 % 3]);
  }
  return twin;
}

Eigen::Vector2d place_px(int x, int y) { return {300.0 + 2.3 * x + 0.1 * y, 200.0 - 0.2 * x + 1.9 * y}; }

double mean_of_wave(double cycles) { return std::sin(kPi * cycles) / (kPi * cycles); }

/// Returns what a pixel's square and the camera's blur leave of a wave along an axis of the projector.
double camera_leaves(double per_px, Axis axis) {
  const double gx = axis == Axis::x ? 2.3 : -0.2, gy = axis == Axis::x ? 0.1 : 1.9;
  return mean_of_wave(per_px * gx) * mean_of_wave(per_px * gy) *
         std::exp(-2.0 * kPi * kPi * per_px * per_px * (gx * gx + gy * gy) * 0.3 * 0.3);
}

double blur_leaves(double per_px) { return std::exp(-2.0 * kPi * kPi * per_px * per_px * 0.7 * 0.7); }

/// Returns the gray value of an image of the sequence, as recorded or as plain fringes make it.
double gray_dn(const Twin& twin, std::size_t image, const Eigen::Vector2d& at_px, bool plain) {
  const DirectionFringes& d = twin.fringes.directions[image / kSteps];
  const double pitch = d.pitches_px[0], origin = d.phase_origin_px[0],
               step = static_cast<double>(image % kSteps) / kSteps;
  const double middle = d.axis == Axis::x ? 640 : 360, along = d.axis == Axis::x ? at_px.x() : at_px.y();
  // light of a wave a cos t + b sin t per full scale, of so many turns per px
  const auto seen = [&](const Harmonic& h, double t, double per_px) {
    return camera_leaves(per_px, d.axis) * blur_leaves(per_px) *
           (h.cosine * std::cos(t) + h.sine * std::sin(t));
  };
  const auto fringe = [&](double x) {
    const double t = 2.0 * kPi * ((x - origin) / pitch + step);
    double light = seen({twin.fringes.amplitude, 0.0}, t, 1.0 / pitch);
    if (plain) return light;
    const double u = 2.0 * (at_px.x() + 0.5) / 1280 - 1.0, v = 2.0 * (at_px.y() + 0.5) / 720 - 1.0;
    for (int k = 2; k <= 4; ++k)
      light += seen(d.harmonics[0][static_cast<std::size_t>(k - 2)], k * t, k / pitch);
    light +=
        seen({0.004 * u, 0.003 * v}, 2.0 * t, 2.0 / pitch) + seen({0.002 * v, 0.0}, 3.0 * t, 3.0 / pitch);
    const Harmonics& own = twin.fringes.harmonics_of_image(image);
    for (std::size_t i = 0; i < own.size(); ++i)
      light += seen(own[i], (static_cast<double>(i) + 1.0) * t, (static_cast<double>(i) + 1.0) / pitch);
    for (int k = 21; k <= 22; ++k) {
      const double per_px = k / pitch - 1.0 / 1.07,
                   square = std::sin(kPi * per_px * 1.07) / (kPi * per_px * 1.07);
      light += square * seen(d.raster.waves[static_cast<std::size_t>(k - 21)],
                             k * t - 2.0 * kPi * (x - middle) / 1.07, per_px);
    }
    return light;
  };
  const double per_light =
      kAmplitudeDn / (twin.fringes.amplitude * blur_leaves(1.0 / pitch) * camera_leaves(1.0 / pitch, d.axis));
  const double of_room_dn = kMeanDn - per_light * twin.fringes.mean;
  if (plain) return kBlackDn + of_room_dn + per_light * (twin.fringes.mean + fringe(along));
  const Projector& p = *twin.projector;
  return kBlackDn + twin.cameras[0].exposure_factors[image] *
                        (of_room_dn + per_light * p.light_factors[image] *
                                          (twin.fringes.mean + fringe(along - p.image_shifts_px[image])));
}

CameraImages recorded(const Twin& twin, bool plain) {
  CameraImages out;
  for (std::size_t i = 0; i < 2 * kSteps; ++i) {
    ImageF image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        image(x, y) = static_cast<float>(gray_dn(twin, i, place_px(x, y), plain));
    out.images.push_back(std::move(image));
  }
  return out;
}

TEST(KnownLight, IsTakenOutOfTheStepsThatAreAskedFor) {
  const Twin twin = knowing_twin();
  ASSERT_TRUE(knows_light(twin, twin.cameras[0]));
  CameraImages with = recorded(twin, false);
  const CameraImages plain = recorded(twin, true);
  for (const float off : {0.0F, 1.0F}) {
    std::vector<Eigen::Vector2f> places;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        places.push_back(place_px(x, y).cast<float>() +
                         off * Eigen::Vector2f(x % 2 == 0 ? 8.0F : -7.0F, 5.0F));
    places[7] = {300.0F, std::numeric_limits<float>::quiet_NaN()};
    with.images[2].writable(12, 3) = 255.0F;  // clipped
    const std::vector<int> even{0, 2, 4, 6, 8, 10};
    const CameraImages found = without_known_light(with, twin, twin.cameras[0], places, even);
    double before = 0.0;
    for (std::size_t i = 0; i < found.images.size(); ++i)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          // the slopes of places that are made to be off are told between every second pixel
          if (x == 0 || x == kWidth - 1 || (x >= 6 && x <= 8 && y <= 1)) continue;
          const bool kept = i % 2 == 1 || (x == 12 && y == 3 && i < kSteps);
          float expected = (kept ? with : plain).images[i](x, y);
          if (x == 12 && y == 3 && i == 2) expected = static_cast<float>(found.clip->dn);
          ASSERT_NEAR(found.images[i](x, y), expected,
                      kept         ? 0.0
                      : off > 0.0F ? 0.04
                                   : 2e-3)
              << i << ' ' << x << ' ' << y;
          before =
              std::max(before, static_cast<double>(std::abs(with.images[i](x, y) - plain.images[i](x, y))));
        }
    EXPECT_GT(before, 1.0);
    // without a place all that needs none is taken out: 3 DN of light and exposures, but not 0.5 DN of waves
    for (std::size_t i = 0; i < kSteps; i += 2) EXPECT_NEAR(found.images[i][7], plain.images[i][7], 1.0) << i;
  }
}

// A bright pixel that goes beyond full scale as its light is taken to the mean is not clipped.
TEST(KnownLight, LeavesBrightPixelsUsable) {
  Twin twin = testing::paper_rig();
  twin.cameras.erase(twin.cameras.begin() + 1, twin.cameras.end());
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {900, 900, 4, 4}, {8, 8}, "test");
  twin.fringes = {
      .directions = {{Axis::x, {32.0}, {0.0}, {}}}, .steps = 4, .unwrap = Unwrap::none, .images = {}};
  twin.cameras[0].exposure_factors = {2.0, 2.0, 1.9, 2.1};
  CameraImages images;
  for (const float dn : {253.0F, 150.0F, 50.0F, 150.0F}) images.images.push_back(ImageF(8, 8, dn));
  images.images[2].writable(3, 3) = 255.0F;
  const std::vector<Eigen::Vector2f> places(64, Eigen::Vector2f(100.0F, 100.0F));
  const CameraImages found = without_known_light(images, twin, twin.cameras[0], places);
  const double mean = std::pow(2.0 * 2.0 * 1.9 * 2.1, 0.25);
  EXPECT_NEAR(found.images[0](0, 0), 253.0 * mean / 2.0, 1e-4);
  EXPECT_NEAR(found.images[2](0, 0), 50.0 * mean / 1.9, 1e-4);
  EXPECT_LT(found.images[0](0, 0), found.saturation_dn());
  EXPECT_GE(found.images[2](3, 3), found.saturation_dn());
}

TEST(KnownLight, IsNoneOfPlainFringesAndOfThoseThatAreNoSumOfWaves) {
  Twin twin = knowing_twin();
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  EXPECT_FALSE(knows_light(twin, twin.cameras[0]));
  const Twin plain = testing::paper_rig();
  EXPECT_FALSE(knows_light(plain, plain.cameras[0]));
}

}  // namespace
}  // namespace fringetwin::cosim::known_light_test
