// SPDX-License-Identifier: Apache-2.0
// Fine fringes, silhouettes, deep sensors.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 4e-5      | rad rms        | required, times 13/pitch: rounding of the projector coordinate        |
// | 5e-5      | full scale rms | required                                                             |
// | 1e-4      | rad, full scale | default sampling: its own target, the phase times 13/pitch            |
// | 1e-4      | full scale rms | default sampling at silhouettes: its target, an rms over all pixels   |
// | 1/sqrt(N) |                | coverage of a pixel by N jittered samples: 3 sigma of N^-3/4          |
// | 1         | DN of 16 bits  | rounding to integers of two values a few 1e-7 apart                   |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/sensor/sensor.hpp"
#include "tests/support/hard_support.hpp"

namespace fringetwin::testing::fringes_test {
namespace {

using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

Twin with_pitch(Twin twin, double pitch_px) {
  twin.fringes.directions[0].pitches_px = {pitch_px};
  twin.fringes.directions[0].phase_origin_px = {0.0};
  twin.fringes.unwrap = Unwrap::none;
  return twin;
}

void expect_fringes(const std::string& what, const Twin& twin, int samples, double pitch_px) {
  const auto block = whole_image(twin, 0, 4);
  const auto truth = reference_block(render::Reference(twin), 0, block, {.gauss_n = 24});
  const auto run = [&](const render::Sampling& s) {
    return compare(twin, 0, shared_renderer()->render(twin, 0, s).irradiance, truth, Pixels::interior);
  };
  const Agreement by_default = run(render::choose_sampling(twin)), a = run({Sampler::gauss, samples});
  const Agreement one = run({Sampler::gauss, 1});
  report(what, fmt::format("one ray: {:.1e} rad, gray {:.1e}", one.worst_phase_rms_rad(), one.gray_rms),
         fmt::format("default {:.1e} rad, gray {:.1e}; {} samples {:.1e} rad, gray {:.1e}",
                     by_default.worst_phase_rms_rad(), by_default.gray_rms, samples, a.worst_phase_rms_rad(),
                     a.gray_rms));
  EXPECT_GT(a.n, 200) << what;
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5 * std::max(1.0, 13.0 / pitch_px)) << what;
  EXPECT_LE(a.gray_rms, 5e-5) << what;
  EXPECT_LE(by_default.worst_phase_rms_rad(), twin.render.phase_error_rad * std::max(1.0, 13.0 / pitch_px))
      << what;
  EXPECT_LE(by_default.gray_rms, twin.render.gray_error) << what;
}

TEST(HardFringes, PitchNearNyquist) {
  REQUIRE_RENDERER();
  for (const double pitch : {4.0, 3.0, 2.0}) {
    const Twin rig = with_pitch(left_window({0, 0, 250}, 120, 96), pitch);
    expect_fringes(fmt::format("pitch {} px on a sphere", pitch),
                   with_object(rig, "ball", SphereShape{{0, 0, 268}, 18.0}), 16, pitch);
  }
}

// A camera of 300 px focal length sees 1.4 ... 2.8 periods in a pixel: contrast 0.2 and less, of either sign.
TEST(HardFringes, SeveralFringesInAPixel) {
  REQUIRE_RENDERER();
  for (const double pitch : {4.0, 2.1}) {
    const Twin rig = with_pitch(bench_rig(300.0, 81, 61, 40.0), pitch);
    expect_fringes(fmt::format("{:.1f} periods in a camera pixel", 1700.0 / 300.0 / pitch),
                   with_object(rig, "plane", frontal_plane(300.0)), 256, pitch);
  }
}

// ---------------------------------------------------------------- silhouettes

/// Area of the part of the disk around the origin that lies in [x0, x1] x [y0, y1], by the integral of
/// its chord over x: exact antiderivatives between the points where the chord meets the sides.
double disk_in_square(double r, double x0, double x1, double y0, double y1) {
  const auto primitive = [r](double x) {  // of sqrt(r^2 - x^2)
    const double c = std::clamp(x, -r, r);
    return 0.5 * (c * std::sqrt(std::max(0.0, r * r - c * c)) + r * r * std::asin(c / r));
  };
  std::vector<double> cuts{std::clamp(x0, -r, r), std::clamp(x1, -r, r)};
  for (const double y : {y0, y1})
    if (std::abs(y) < r)
      for (const double x : {-std::sqrt(r * r - y * y), std::sqrt(r * r - y * y)})
        if (x > cuts[0] && x < cuts[1]) cuts.push_back(x);
  std::sort(cuts.begin(), cuts.end());
  double area = 0.0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i], b = cuts[i + 1], m = 0.5 * (a + b), h = std::sqrt(std::max(0.0, r * r - m * m));
    const double top = std::min(h, y1), bottom = std::max(-h, y0);
    if (top <= bottom) continue;
    const double chord = primitive(b) - primitive(a);
    area += (h < y1 ? chord : y1 * (b - a)) - (-h > y0 ? -chord : y0 * (b - a));
  }
  return area;
}

TEST(HardFringes, SilhouetteOfASphere) {
  REQUIRE_RENDERER();
  Twin twin = bench_rig(1000.0, 201, 181);
  twin.projector->ambient = 1.0;
  twin = with_object(twin, "ball", SphereShape{{0, 0, 280}, 20.0});
  const double r = 1000.0 * 20.0 / std::sqrt(280.0 * 280.0 - 400.0);
  for (const auto& s : {render::choose_sampling(twin),
                        {Sampler::gauss, 1},
                        {Sampler::gauss, 4},
                        {Sampler::multi_jittered, 64},
                        {Sampler::multi_jittered, 256},
                        {Sampler::multi_jittered, 1024}}) {
    const auto t = shared_renderer()->trace(twin, 0, s, 3);
    double sum = 0.0, worst = 0.0;
    int edge = 0, wrong = 0, lit = 0;
    for (int y = 0; y < 181; ++y)
      for (int x = 0; x < 201; ++x) {
        const double truth = disk_in_square(r, x - 100.5, x - 99.5, y - 90.5, y - 89.5);
        const double d = std::abs(t.ambient(x, y) - truth);
        lit += truth > 0.0;
        if (truth > 1e-9 && truth < 1.0 - 1e-9) {
          ++edge;
          sum += d * d;
          worst = std::max(worst, d);
        } else {
          wrong += d > 1e-6;
        }
      }
    const double rms = std::sqrt(sum / edge);
    const std::string scheme = s.sampler == Sampler::adaptive ? "default"
                               : s.sampler == Sampler::gauss  ? fmt::format("gauss {}", s.samples)
                                                              : fmt::format("multi-jittered {}", s.samples);
    report(fmt::format("{} silhouette pixels, {}", edge, scheme), "",
           fmt::format("coverage {:.1e} rms, {:.1e} max; {} inner or outer pixels wrong", rms, worst, wrong));
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(edge, 400);
    if (s.sampler == Sampler::adaptive) {
      // Full coverage is this much of the sensor's scale.
      const double scale =
          twin.projector->ambient * twin.cameras[0].sensor.gain_dn / twin.cameras[0].sensor.max_dn();
      EXPECT_LE(scale * std::sqrt(sum / lit), s.gray_error);
    }
    if (s.sampler == Sampler::multi_jittered) {
      EXPECT_LE(rms, std::pow(s.samples, -0.75));
      EXPECT_LE(worst, 6.0 * std::pow(s.samples, -0.75));
    }
  }
}

// ---------------------------------------------------------------- deep sensors

TEST(HardFringes, SixteenBitSensor) {
  REQUIRE_RENDERER();
  Twin twin = with_object(left_window({0, 0, 250}, 160, 140), "sphere", ideal_sphere());
  twin.cameras[0].sensor = Sensor{};
  twin.cameras[0].sensor.bit_depth = 16;
  twin.cameras[0].sensor.gain_dn = 6000.0;
  twin.cameras[0].sensor.black_level_dn = 250.0;
  for (const double target : {1e-4, 1e-5}) {
    twin.render.phase_error_rad = target;
    const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
    const auto truth =
        reference_block(render::Reference(twin), 0, whole_image(twin, 0, 3), {.gauss_n = 8}, true);
    int n = 0, differ = 0;
    double worst = 0.0, brightest = 0.0;
    for (std::size_t i = 0; i < rendered.irradiance.size(); ++i) {
      const ImageF dn =
          render::expose(rendered.irradiance[i], twin.cameras[0].sensor, 0, 0, static_cast<std::uint32_t>(i));
      for (const auto& p : truth) {
        const double expected = std::round(6000.0 * p.pixel.irradiance[i] + 250.0);
        const double d = std::abs(dn(p.x, p.y) - expected);
        ++n;
        differ += d > 0.0;
        worst = std::max(worst, d);
        brightest = std::max(brightest, expected);
      }
    }
    report(fmt::format("16-bit sensor, brightest {:.0f} DN, target {:g} rad", brightest, target),
           "8 bits resolve 257 of these DN",
           fmt::format("{} of {} values differ, by at most {} DN", differ, n, worst));
    EXPECT_GT(brightest, 40'000);
    EXPECT_LT(brightest, 65'535);
    EXPECT_LE(worst, target < 5e-5 ? 1.0 : 4.0);
  }
}

}  // namespace
}  // namespace fringetwin::testing::fringes_test
