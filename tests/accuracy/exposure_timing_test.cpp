// SPDX-License-Identifier: Apache-2.0
// Exposures that are late, short or read out row by row, against the double-precision reference, which
// integrates what is shown over the time of each row's exposure.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes                                                    |
// | 1e-4      | rad rms        | point spread: as in materials_test.cpp                               |
// | 3e-4      | full scale rms | point spread: as in materials_test.cpp                               |
// | 2.5e-3    | irradiance     | motion: two times for a row's exposure; of a fringe that goes on by w  |
// |           |                | rad in a period they leave A w^2/2 (R^2/4 - R^2/12), read-out R =    |
// |           |                | 0.5, A = 5; w = 0.09 on average (1 rad over 11 periods): 8.7e-4      |
// | 0         |                | off = bitwise the same image                                         |
#include <gtest/gtest.h>

#include <cmath>

#include "render/base/quadrature.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::exposure_timing_test {
namespace {

constexpr std::size_t kImages = 12;

Twin window(int width = 120, int height = 90) {
  Twin twin = with_object(left_window(physical_sphere().center_mm, width, height), "ball", physical_sphere());
  twin.projector->ambient = 0.3;
  return twin;
}

/// Light and exposures that differ from image to image.
void give_factors(Twin& twin) {
  for (std::size_t k = 0; k < kImages; ++k) {
    const auto at = static_cast<double>(k);
    twin.projector->light_factors.push_back(1.0 + 0.05 * std::sin(1.0 + 2.0 * at));
    twin.projector->ambient_factors.push_back(1.0 + 0.3 * std::cos(at));
    twin.cameras[0].exposure_factors.push_back(1.0 - 0.02 * at);
  }
}

ExposureTiming rolling(double exposure = 1.0) {
  ExposureTiming timing{.exposure = exposure, .read_out = 0.4};
  for (std::size_t k = 0; k < kImages; ++k)
    timing.late.push_back(0.1 * std::sin(0.7 + 1.3 * static_cast<double>(k)));
  return timing;
}

TEST(ExposureTimings, OffChangesNoBit) {
  REQUIRE_RENDERER();
  Twin twin = window();
  give_factors(twin);
  const auto render = [&] { return shared_renderer()->render(twin, 0, render::choose_sampling(twin)); };
  const render::RenderedCamera before = render();
  twin.cameras[0].timing = ExposureTiming{};
  expect_same_bits(before, render());
  twin.cameras[0].timing = ExposureTiming{.exposure = 0.5, .read_out = 0.4, .late = {0.25}};
  expect_same_bits(before, render());
  twin.cameras[0].timing = rolling();
  EXPECT_GT(largest_difference(before, render()), 0.1);
}

TEST(ExposureTimings, AgreeWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = window();
  twin.cameras[0].timing = rolling();
  expect_agreement(twin, "rolling shutter", 200);
  give_factors(twin);
  expect_agreement(twin, "rolling shutter, light per image", 200);
  twin.cameras[0].timing = rolling(0.7);
  twin.cameras[0].vignetting = {Vignetting::Kind::polynomial, {-0.04, 0.01, 0.0}};
  twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
  expect_agreement(twin, "short exposures, gamma, vignetting", 200);
}

TEST(ExposureTimings, AgreeWithTheReferenceBehindAPointSpread) {
  REQUIRE_RENDERER();
  Twin twin = window();
  give_factors(twin);
  twin.cameras[0].timing = rolling();
  twin.cameras[0].psf_px = 0.8;
  const render::Reference reference(twin);
  const auto truth = reference_block(reference, 0, {20, 20, 80, 50, 11}, {.gauss_n = 3});
  const Agreement a = compare(twin, 0, render_fixed(twin).irradiance, truth);
  std::cout << "rolling shutter behind a point spread: " << a.text() << "\n";
  EXPECT_GE(a.n, 20);
  EXPECT_LE(a.worst_phase_rms_rad(), 1e-4);
  EXPECT_LE(a.gray_rms, 3e-4);
}

/// The same rig with one colour of its sensor as the image.
Twin blue_of(Twin twin) {
  Camera& camera = twin.cameras[0];
  camera.channel = MosaicChannel{"RGGB", MosaicColour::blue, {camera.lens.width(), camera.lens.height()}};
  camera.lens = image_lens(camera.lens, *camera.channel, "test");
  return twin;
}

// Rows are those of the sensor: with a point spread the same trace, of which pixels are taken.
TEST(ExposureTimings, RowsOfAColourAreThoseOfTheSensor) {
  REQUIRE_RENDERER();
  Twin sensor = window();
  sensor.cameras[0].timing = rolling();
  expect_agreement(blue_of(sensor), "rolling shutter of a colour sensor", 100);
  sensor.cameras[0].psf_px = 0.8;
  const Twin blue = blue_of(sensor);
  const auto whole = shared_renderer()->render(sensor, 0, {Sampler::gauss, 9}),
             images = shared_renderer()->render(blue, 0, {Sampler::gauss, 9});
  for (std::size_t k = 0; k < kImages; ++k)
    EXPECT_EQ(channel_image(whole.irradiance[k], *blue.cameras[0].channel).data, images.irradiance[k].data);
}

/// A sphere that moves, about its place.
struct MovingBall {
  Twin twin = window(60, 44);
  Eigen::Vector3d way_mm = Eigen::Vector3d(0.08, 0.04, -0.1);

  /// The rig at rest as it is at a time, in images.
  Twin at(double time) const {
    Twin then = twin;
    then.cameras[0].timing.reset();
    std::get<SphereShape>(then.objects[0].shape).center_mm += (time / (kImages - 1.0) - 0.5) * way_mm;
    return then;
  }
  /// The light of a pixel in an image: over the time of its row's exposure, each pattern with the ball where
  /// it is meanwhile.
  double light(std::size_t image, int x, int y) const {
    const ExposureTiming& timing = *twin.cameras[0].timing;
    const double begin = timing.late.at(image) +
                         timing.read_out * ((y + 0.5) / twin.cameras[0].lens.height() - 0.5),
                 end = begin + timing.exposure;
    double sum = 0.0;
    for (int other = -1; other <= 1; ++other) {  // shown from `other` to other + 1
      const double from = std::max<double>(begin, other), to = std::min(end, other + 1.0);
      if (!(to > from)) continue;
      const auto shown = static_cast<std::size_t>(
          std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(image) + other, 0, kImages - 1));
      const render::GaussRule& rule = render::gauss_rule(3);
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double time = 0.5 * (from + to) + 0.5 * (to - from) * rule.nodes[i];
        const render::Reference reference(at(static_cast<double>(image) + time - 0.5));
        sum += 0.5 * rule.weights[i] * (to - from) *
               reference.pixel(0, x, y, {.gauss_n = 3}).irradiance.at(shown);
      }
    }
    return sum / timing.exposure;
  }
};

TEST(ExposureTimings, RowsSeeMovingThingsWhereTheyAreMeanwhile) {
  REQUIRE_RENDERER();
  MovingBall ball;
  ball.twin.cameras[0].timing = rolling(0.8);
  ball.twin.cameras[0].timing->read_out = 0.5;
  Twin moving = ball.twin;
  moving.objects[0].motion = {ball.way_mm.x(), ball.way_mm.y(), ball.way_mm.z()};
  const render::RenderedCamera seen = render_fixed(moving);
  moving.cameras[0].timing.reset();
  const render::RenderedCamera instants = render_fixed(moving);
  moving.cameras[0].timing = ball.twin.cameras[0].timing;
  moving.objects[0].motion.clear();
  const render::RenderedCamera at_rest = render_fixed(moving);
  double without_timing = 0.0, without_motion = 0.0;
  for (const std::size_t k : {0, 1, 4, 7, 11})
    for (const int y : {1, 21, 42})
      for (const int x : {5, 40}) {
        const double truth = ball.light(k, x, y);
        EXPECT_NEAR(static_cast<double>(seen.irradiance[k](x, y)), truth, 2.5e-3)
            << k << ' ' << x << ' ' << y;
        without_timing = std::max(without_timing, std::abs(instants.irradiance[k](x, y) - truth));
        without_motion = std::max(without_motion, std::abs(at_rest.irradiance[k](x, y) - truth));
      }
  EXPECT_GT(without_timing, 0.1);
  EXPECT_GT(without_motion, 0.1);
}

// Exposures that stay within their patterns see things move, too; without the table they are instants.
TEST(ExposureTimings, AWholeExposureIsNotAnInstant) {
  REQUIRE_RENDERER();
  MovingBall ball;
  ball.way_mm *= 60.0;
  Twin moving = ball.twin;
  moving.objects[0].motion = {ball.way_mm.x(), ball.way_mm.y(), ball.way_mm.z()};
  const render::RenderedCamera instants = render_fixed(moving);
  moving.cameras[0].timing = ExposureTiming{};
  const render::RenderedCamera whole = render_fixed(moving);
  // at the middle of the same pattern: A w^2/24 less of a fringe, w = 0.8 rad in a period: 0.14 of 5
  EXPECT_GT(largest_difference(instants, whole), 0.05);
  EXPECT_LT(largest_difference(instants, whole), 0.7);
  // and a short one is nearly an instant: 1 % of that, at the middle of its time
  moving.cameras[0].timing = ExposureTiming{.exposure = 0.1, .read_out = 0.0, .late = {0.45}};
  EXPECT_LT(largest_difference(instants, render_fixed(moving)), 0.01);
}

}  // namespace
}  // namespace fringetwin::testing::exposure_timing_test
