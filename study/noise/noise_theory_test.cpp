// SPDX-License-Identifier: Apache-2.0
// The theory of the noise against formulas of the textbook rig: parallel axes, a narrow field, a plane
// across. tolerance: 0.3 % (the field's edge is 0.3 degrees off the axis; the fit's limit of four scales
// takes 0.05 %).
#include "study/noise/noise_theory.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::noise_theory_test {
namespace {

using study::NoiseTheory, study::noise_theory;
using ::testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

constexpr double kDepth = 500.0, kProjectorBaseline = 100.0, kCameraBaseline = 60.0, kCameraFocal = 10000.0,
                 kProjectorFocal = 1000.0, kGain = 300.0, kRead = 2.0, kPitch = 20.0;

std::string rig(const std::string& measure) {
  return R"(schema = "fringetwin-twin/1"
[[camera]]
name = "left"
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [100, 100]
intrinsics = [10000, 10000, 49.5, 49.5]
rt_cam_world = [0, 0, 0, 0, 0, 0]
[camera.sensor]
bit_depth = 12
gain_dn = 300
read_noise_dn = 2
[[camera]]
name = "right"
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [3000, 120]
intrinsics = [10000, 10000, 1499.5, 59.5]
rt_cam_world = [0, 0, 0, -60, 0, 0]
[camera.sensor]
bit_depth = 12
gain_dn = 300
read_noise_dn = 2
[projector]
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [1000, 600]
intrinsics = [1000, 1000, 499.5, 299.5]
rt_cam_world = [0, 0, 0, -100, 0, 0]
intensity = 40
[fringes]
directions = ["x"]
pitches_px = [1000, 100, 20]
steps = 6
unwrap = "hierarchical"
[[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 500]
normal = [0, 0, -1]
[object.material]
diffuse = 0.7
[[measure.fit]]
object = "wall"
)" + measure;
}

Twin twin_of(const std::string& text) {
  const auto file = scratch_folder("noise_theory") / "twin.toml";
  write_file(file, text);
  return load_twin(file);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Of the projector's coordinate.
double coordinate_sigma_px() {
  const double cosine = kDepth / std::hypot(kDepth, kProjectorBaseline);
  const double amplitude_dn = kGain * 0.5 * 40.0 * 0.7 / kPi * cosine;
  return kPitch / (2.0 * kPi) * std::sqrt(2.0 / 6.0 * (kRead * kRead + 1.0 / 12.0)) / amplitude_dn;
}

TEST(NoiseTheory, ACameraAndAProjectorSideBySide) {
  const NoiseTheory t = noise_theory(twin_of(rig("[measure]\ntriangulate = \"projector\"\n")), "wall");
  const double expected_mm = kDepth * kDepth / (kProjectorFocal * kProjectorBaseline) * coordinate_sigma_px();
  EXPECT_NEAR(t.rms_mm, expected_mm, 3e-3 * expected_mm);
  EXPECT_NEAR(t.n, 1e4, 1.0);
  EXPECT_NEAR(t.offset_sigma_mm, expected_mm / 100.0, 3e-5 * expected_mm);
}

TEST(NoiseTheory, TwoCamerasSideBySide) {
  const NoiseTheory t = noise_theory(twin_of(rig("[measure]\ntriangulate = \"stereo\"\n")), "wall");
  // Lagrange cubics between pixels leave 733/945 of the variance per axis (integral of squared weights)
  const double kept = 733.0 / 945.0 * 733.0 / 945.0;
  const double disparity_px = std::sqrt(1.0 + kept) * coordinate_sigma_px() * kCameraFocal / kProjectorFocal;
  const double expected_mm = kDepth * kDepth / (kCameraFocal * kCameraBaseline) * disparity_px;
  EXPECT_NEAR(t.rms_mm, expected_mm, 3e-3 * expected_mm);
  const double all_mm = expected_mm * std::sqrt(2.0 / (1.0 + kept)) / 100.0;
  EXPECT_NEAR(t.offset_sigma_mm, all_mm, 3e-3 * all_mm) << "interpolation does not make noise less in sums";
}

// The brightest of the wall's pixels reaches 2622 DN over black of the 4095: with 1400 DN of black it is
// within range, with 1500 DN it is clipped. Black has no shot noise.
TEST(NoiseTheory, TheBlackLevelTakesRangeAndAddsNoNoise) {
  const auto with_black = [](double black_dn) {
    Twin twin = twin_of(rig("[measure]\ntriangulate = \"projector\"\n"));
    twin.cameras[0].sensor.electrons_per_dn = 4.0;
    twin.cameras[0].sensor.black_level_dn = black_dn;
    return noise_theory(twin, "wall");
  };
  EXPECT_EQ(with_black(1400.0).n, with_black(0.0).n);
  EXPECT_EQ(with_black(1400.0).rms_mm, with_black(0.0).rms_mm);
  EXPECT_EQ(with_black(1500.0).n, 0.0);
}

// Half of the projector's light and all of the room's make electrons, whatever the fringes' amplitude.
TEST(NoiseTheory, ShotNoiseIsThatOfAllLight) {
  Twin twin = twin_of(rig("[measure]\ntriangulate = \"projector\"\n"));
  const double read_mm = noise_theory(twin, "wall").rms_mm;
  twin.cameras[0].sensor.electrons_per_dn = 50.0;
  twin.projector->ambient = 4.0;
  const double cosine = kDepth / std::hypot(kDepth, kProjectorBaseline);
  const double signal_dn = kGain * (0.5 * 40.0 * 0.7 / kPi * cosine + 4.0),
               read_dn2 = kRead * kRead + 1.0 / 12.0;
  const double expected_mm = read_mm * std::sqrt(1.0 + signal_dn / 50.0 / read_dn2);
  EXPECT_NEAR(noise_theory(twin, "wall").rms_mm, expected_mm, 3e-3 * expected_mm);
}

// Heterodyne fringes are averaged by their weights: information goes with one over the squared pitch.
TEST(NoiseTheory, HeterodyneFringesShareTheNoise) {
  Twin twin = twin_of(rig("[measure]\ntriangulate = \"projector\"\n"));
  const double finest_mm = noise_theory(twin, "wall").rms_mm;  // of 20 px
  twin.fringes.directions[0].pitches_px = {20.0, 22.0, 25.0};
  twin.fringes.unwrap = Unwrap::heterodyne;
  const double expected_mm = finest_mm / std::sqrt(1.0 + std::pow(20.0 / 22.0, 2) + std::pow(20.0 / 25.0, 2));
  EXPECT_NEAR(noise_theory(twin, "wall").rms_mm, expected_mm, 3e-3 * expected_mm);
}

// A camera pixel sees 0.1 px of the projector: fringes of 0.2 px keep 2/pi of their contrast, of a pixel half
// as wide sin(pi/4)/(pi/4).
TEST(NoiseTheory, APixelAveragesTheFringesThatItSees) {
  Twin twin = twin_of(rig("[measure]\ntriangulate = \"projector\"\n"));
  const double wide_mm = noise_theory(twin, "wall").rms_mm;
  twin.fringes.directions[0].pitches_px[2] = 0.2;
  for (const auto& [fill, contrast] : {std::pair{1.0, 2.0 / kPi}, {0.5, std::sin(kPi / 4.0) / (kPi / 4.0)}}) {
    twin.render.pixel_fill = fill;
    const double expected_mm = wide_mm * 0.2 / kPitch / contrast;
    EXPECT_NEAR(noise_theory(twin, "wall").rms_mm, expected_mm, 3e-3 * expected_mm) << fill;
  }
}

// The same rig, turned by a quarter about the camera's axis: fringes along y, the projector below.
TEST(NoiseTheory, FringesAlongYAreThoseAlongXTurned) {
  const double along_x_mm =
      noise_theory(twin_of(rig("[measure]\ntriangulate = \"projector\"\n")), "wall").rms_mm;
  std::string text = replaced(rig("[measure]\ntriangulate = \"projector\"\n"), "directions = [\"x\"]",
                              "directions = [\"y\"]");
  text = replaced(text, "[0, 0, 0, -100, 0, 0]", "[0, 0, 0, 0, -100, 0]");
  EXPECT_NEAR(noise_theory(twin_of(text), "wall").rms_mm, along_x_mm, 3e-3 * along_x_mm);
}

// With read noise alone, sigma goes with one over the light, and that with one over the squared distance.
TEST(NoiseTheory, LightFallsWithTheSquareOfTheDistance) {
  Twin twin = twin_of(rig("[measure]\ntriangulate = \"projector\"\n"));
  const double even_mm = noise_theory(twin, "wall").rms_mm;
  twin.projector->inverse_square = true;
  twin.projector->reference_distance_mm = 400.0;
  const double expected_mm = even_mm * std::pow(std::hypot(kDepth, kProjectorBaseline) / 400.0, 2);
  EXPECT_NEAR(noise_theory(twin, "wall").rms_mm, expected_mm, 3e-3 * expected_mm);
}

// A sphere's centre and radius are sums over its points: there the noise of either camera counts in full, in
// a single point only 733/945 of the right one's sigma. 6 %: slope stretches the right image (by 4 % at 45
// degrees), and the outermost pixels, 3 % of all, are not the same in both. 3 % of single points.
TEST(NoiseTheory, BothCamerasNoiseCountsAlikeInASphere) {
  const auto noisy = [](std::size_t camera) {
    std::string text = rig("[render]\npixel_fill = 0.1\n[measure]\ntriangulate = \"stereo\"\n");
    text = replaced(text, "shape = \"plane\"\npoint_mm = [0, 0, 500]\nnormal = [0, 0, -1]",
                    "shape = \"sphere\"\ncenter_mm = [0, 0, 500]\nradius_mm = 2");
    Twin twin = twin_of(replaced(text, "[0, 0, 0, -60, 0, 0]", "[0, 0, 0, -20, 0, 0]"));
    twin.cameras[camera].sensor.read_noise_dn = 100.0;
    twin.cameras[1 - camera].sensor.read_noise_dn = 0.1;
    return noise_theory(twin, "wall");
  };
  const NoiseTheory left = noisy(0), right = noisy(1);
  EXPECT_NEAR(right.rms_mm / left.rms_mm, 733.0 / 945.0, 0.03);
  EXPECT_NEAR(right.radius_sigma_mm / left.radius_sigma_mm, 1.0, 0.06);
  EXPECT_NEAR(right.center_sigma_mm.z() / left.center_sigma_mm.z(), 1.0, 0.06);
}

// A pixel is 0.05 mm of the wall, which ends 40.7 pixels from the middle, where two pixels meet. The
// coordinate changes by 0.1 px per pixel and has 0.005 px of noise: a pixel that is a quarter empty is
// displaced by more. Above and below the image ends, which is no border. 1e-4: the share that the fit leaves
// out.
TEST(NoiseTheory, BorderPixelsThatAreCutTakeNoPart) {
  const auto columns = [](const std::string& measure, double width_mm, const std::string& fill) {
    std::string text =
        rig("[render]\npixel_fill = " + fill + "\n[measure]\ntriangulate = \"" + measure + "\"\n");
    text = replaced(text, "normal = [0, 0, -1]",
                    fmt::format("normal = [0, 0, -1]\nsize_mm = [{}, 100]", width_mm));
    text = replaced(text, "[0, 0, 0, -60, 0, 0]", "[0, 0, 0, -60.025, 0, 0]");
    return noise_theory(twin_of(text), "wall").n / 100.0;
  };
  EXPECT_NEAR(columns("projector", 4.07, "1"), 80.0, 1e-4 * 80.0) << "the 41st sees the wall, but is cut";
  EXPECT_NEAR(columns("projector", 4.07, "0.1"), 82.0, 1e-4 * 82.0) << "nothing is cut";
  // the right camera's pixels lie half a pixel aside: its 41st sees the wall, is cut and missing beside the
  // 40th
  EXPECT_NEAR(columns("stereo", 4.07, "1"), 78.0, 1e-4 * 78.0);
  EXPECT_NEAR(columns("stereo", 4.07, "0.1"), 80.0, 1e-4 * 80.0);
}

TEST(NoiseTheory, BlurHasItsBestPitch) {
  // sigma ~ p exp(2 pi^2 blur^2 / p^2) is least at p = 2 pi blur
  const double blur_px = 3.0;
  const auto sigma = [&](double pitch) {
    Twin twin = twin_of(rig("[measure]\ntriangulate = \"projector\"\n"));
    twin.projector->blur_px = blur_px;
    twin.fringes.directions[0].pitches_px[2] = pitch;
    return noise_theory(twin, "wall").rms_mm;
  };
  const double best = 2.0 * kPi * blur_px;
  EXPECT_GT(sigma(0.95 * best), sigma(best));
  EXPECT_GT(sigma(1.05 * best), sigma(best));
  const double ratio = 0.6 * std::exp(0.5 * (1.0 / 0.36 - 1.0));
  EXPECT_NEAR(sigma(0.6 * best) / sigma(best), ratio, 3e-3 * ratio);
}

TEST(NoiseTheory, TheOtherSideOfASphereTakesNoPart) {
  const Twin twin = twin_of(small_twin());
  const NoiseTheory t = noise_theory(twin, "ball");
  const double whole_disk = kPi * std::pow(260.0 * 19.0 / std::sqrt(270.0 * 270.0 - 19.0 * 19.0), 2);
  EXPECT_LT(t.n, whole_disk);
  EXPECT_GT(t.n, 0.5 * whole_disk);
  EXPECT_GT(t.center_sigma_mm.z(), t.center_sigma_mm.y()) << "depth is the weak direction";
}

TEST(NoiseTheory, WithoutAUsableFringeThereIsNothingToExpect) {
  Twin twin = twin_of(small_twin());
  twin.cameras[0].sensor.gain_dn = 1e6;  // all saturated
  const NoiseTheory t = noise_theory(twin, "ball");
  EXPECT_EQ(t.n, 0.0);
  EXPECT_TRUE(std::isnan(t.rms_mm) && std::isnan(t.radius_sigma_mm));
}

TEST(NoiseTheory, WhatItDoesNotKnowIsRefused) {
  const Twin twin = twin_of(small_twin());
  const auto refused = [&](const std::function<void(Twin&)>& change) {
    Twin other = twin;
    change(other);
    try {
      noise_theory(other, "ball");
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused([](Twin&) {}), "accepted");
  EXPECT_THAT(refused([](Twin& t) { t.objects[0].name = "other"; }), HasSubstr("\"ball\""));
  EXPECT_THAT(refused([](Twin& t) { t.objects.push_back(t.objects[0]); }), HasSubstr("2 objects in a scene"));
  EXPECT_THAT(refused([](Twin& t) { t.fringes.steps = 3; }), HasSubstr("fringes.steps = 3"));
  EXPECT_THAT(refused([](Twin& t) { t.cameras[0].psf_px = 1.0; }), HasSubstr("camera.left.psf_px = 1"));
  EXPECT_THAT(refused([](Twin& t) { t.render.bounces = 1; }), HasSubstr("render.bounces = 1"));
}

}  // namespace
}  // namespace fringetwin::testing::noise_theory_test
