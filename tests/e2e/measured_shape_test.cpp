// SPDX-License-Identifier: Apache-2.0
// A ball seen through its own measured shape: a right twin, whose shape has the noise of the steps that it
// was built from, is explained; one whose fringes are not the twin's is not. Limits are the program's own (1
// right row in 370 fails).
//
// | check           | tolerance | origin                                                       |
// |-----------------|-----------|--------------------------------------------------------------|
// | shading         | 15 %      | of a variance: Tukey's weights, smaller windows at borders   |
// | texture besides | 5 %       | 15 % of a fifth of it as shading, values near black          |
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::measured_shape_test {
namespace {

using nlohmann::json;

constexpr const char* kBall = "shape = \"sphere\"\ncenter_mm = [0, 0, 330]\nradius_mm = 60\n";

/// A camera that sees nothing but the ball, and one that sees its outline.
const std::string kInside = "imagersize = [320, 320]\nintrinsics = [2000, 2000, 159.5, 159.5",
                  kWhole = "imagersize = [400, 400]\nintrinsics = [800, 800, 199.5, 199.5";

using Replacements = std::vector<std::pair<std::string, std::string>>;

/// A second camera, which sees the ball from the other side of the projector.
const std::pair<std::string, std::string> kSecondCamera{
    "[projector]", "[[camera]]\nname = \"right\"\nlensmodel = \"LENSMODEL_PINHOLE\"\n" + kInside +
                       "]\nrt_cam_world = [0, 0.2, 0, -60, 0, 5]\n[camera.sensor]\ngain_dn = 15\n"
                       "electrons_per_dn = 60\nread_noise_dn = 0.5\n[projector]"};

/// A ball that fills the image (its outline would tell more of windows than of noise), 8 steps, so that even
/// and odd ones tell it by themselves.
std::string twin_of(const std::string& object, const std::string& fringes, const std::string& extra,
                    const std::string& camera = kInside, const Replacements& rig = {}) {
  Replacements all{{"gain_dn = 20", "gain_dn = 15\nelectrons_per_dn = 60\nread_noise_dn = 0.5"},
                   {"imagersize = [160, 120]\nintrinsics = [260, 260, 79.5, 59.5", camera},
                   {"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19\n", object},
                   {"steps = 4", "steps = 8\n" + fringes},
                   {"[[measure.fit]]\nobject = \"ball\"\n", ""}};
  all.insert(all.end(), rig.begin(), rig.end());
  return small_twin(all, extra);
}

/// What a run differs in from others.
struct Run {
  std::string fringes = "", camera = kInside, smoothing = "smoothing_px = 4\nmost_smoothing_px = 12\n",
              seed = "11", texture = "";
  Replacements rig = {};                  ///< in the truth as in the twin
  std::vector<std::string> options = {};  ///< of the comparison
};

/// Returns what a comparison says of images with these fringes and this texture with the twin, which has
/// none.
json compared(const std::filesystem::path& dir, const Run& r) {
  const std::string with_texture =
      r.texture.empty() ? r.camera : "texture = \"" + r.texture + "\"\n" + r.camera;
  write_file(dir / "truth.toml", twin_of(kBall, r.fringes, "", with_texture, r.rig));
  RunResult run = run_fringetwin(
      {"render", (dir / "truth.toml").string(), "--seed", r.seed, "--out", (dir / "real").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  write_file(dir / "twin.toml", twin_of("shape = \"measured\"\n" + r.smoothing, "",
                                        "[real]\ncaptures = \"real\"\n", r.camera, r.rig));
  std::vector<std::string> cosim{"cosim", (dir / "twin.toml").string(), "--out", (dir / "out").string()};
  cosim.insert(cosim.end(), r.options.begin(), r.options.end());
  run = run_fringetwin(cosim);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return read_json(dir / "out/result.json");
}

// The noise of the shape's depths moves the fringes of whole regions, which the gray values see as the phase
// does: windows of 6 pixels and of 12 share it alike over regions of 16.
TEST(MeasuredShape, ARightTwinIsExplained) {
  FT_NEED_DEVICE();
  for (const std::string seed : {"11", "12", "13"})
    for (const std::string radius_px : {"6", "12"}) {
      const std::string smoothing = "smoothing_px = 4\nmost_smoothing_px = " + radius_px + "\n";
      const json result = compared(scratch_folder("measured_shape"), {.smoothing = smoothing, .seed = seed});
      for (const json& row : result.at("explained"))
        if (row.at("quantity") != "coverage") {
          EXPECT_EQ(row.at("state"), "explained") << seed << ", " << radius_px << row.dump();
          // more noise than there is would hide errors: 0.83 ... 1.06 are seen
          EXPECT_GT(row.at("regional_chi2").get<double>(), 0.75) << seed << ", " << radius_px << row.dump();
        }
    }
}

/// Returns an irregular texture: factors about 1 with this standard deviation.
ImageF texture(double sigma) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(1.0, sigma);
  ImageF factors(320, 320);
  for (float& f : factors.data) f = static_cast<float>(normal(random));
  return factors;
}

/// Expects that phase and gray values are explained, and that the phase's regions have about the noise that
/// their budget says: more would hide errors.
void expect_right(const std::string& name, const Run& r) {
  const json result = compared(scratch_folder("measured_shape_" + name), r);
  for (const json& row : result.at("explained")) {
    const std::string quantity = row.at("quantity");
    if (quantity != "gray" && quantity != "phase") continue;
    EXPECT_EQ(row.at("state"), "explained") << name << ' ' << r.seed << row.dump();
    if (quantity == "phase") {
      EXPECT_GT(row.at("regional_chi2").get<double>(), 0.7) << name << ' ' << r.seed << row.dump();
    }
  }
}

// What the noise of the shape moves depends on the rig: two cameras whose own base is shorter than that of
// the projector make shapes that are noisier than its fringes (without it chi2 of regions was 2.0 ... 2.4 in
// the left camera, and 0.36 in the right one's gray values); it moves fringes along the epipolar lines only;
// and of compared steps that made the shape, too, it has the noise. A texture that the twin was given does
// not hold what its normals are off by (without it chi2 was 1.18).
TEST(MeasuredShape, ARightTwinOfAnyRigIsExplained) {
  FT_NEED_DEVICE();
  const std::pair<std::string, std::string> stereo{"triangulate = \"projector\"", "triangulate = \"stereo\""},
      two_axes{"directions = [\"x\"]", "directions = [\"x\", \"y\"]"},
      aslant{"rt_cam_world = [0, 0.35, 0, -95, 0, 12]", "rt_cam_world = [-0.2, 0.35, 0, -95, -55, 12]"};
  const std::string all_steps = "steps = \"all\"\nsmoothing_px = 4\nmost_smoothing_px = 12\n";
  for (const std::string seed : {"11", "12"}) {
    expect_right("stereo", {.seed = seed, .rig = {kSecondCamera, stereo}});
    expect_right("stereo_of_all", {.smoothing = all_steps, .seed = seed, .rig = {kSecondCamera, stereo}});
  }
  expect_right("even_of_all", {.smoothing = all_steps, .options = {"--steps", "even"}});
  expect_right("second_camera", {.rig = {kSecondCamera}});
  expect_right("two_axes", {.rig = {two_axes}});
  expect_right("aslant", {.rig = {two_axes, aslant}});
  const std::filesystem::path given = scratch_folder("measured_shape_own") / "given.exr";
  const ImageF own = texture(0.05);
  write_exr(given, {{"factor", &own}});
  expect_right("given_texture",
               {.smoothing = "smoothing_px = 3\nmost_smoothing_px = 3\n",
                .rig = {{"lensmodel = \"LENSMODEL_OPENCV4\"",
                         "lensmodel = \"LENSMODEL_OPENCV4\"\ntexture = \"" + given.string() + "\""}}});
}

// Two cameras see more of the noise in the mean of a window than in a point, which the second one's map is
// interpolated for; and a fringe of 30 pixels has windows of 12 within it that ripple together. An image of
// four times as many pixels has limits that tell.
TEST(MeasuredShape, TwoCamerasMakeNoRipples) {
  FT_NEED_DEVICE();
  const std::string fine = "imagersize = [640, 640]\nintrinsics = [4000, 4000, 319.5, 319.5";
  auto second = kSecondCamera;
  second.second.replace(second.second.find(kInside), kInside.size(), fine);
  for (const std::string seed : {"21", "23"})
    expect_right("ripples", {.camera = fine,
                             .seed = seed,
                             .rig = {second, {"triangulate = \"projector\"", "triangulate = \"stereo\""}}});
}

// A ball that fills the image, with a texture of 1 % and without: what a factor per pixel takes is the noise
// of the normals, which the budget predicts, and the texture, which it leaves as reflectivity. Pixels on the
// image's border see as much of the ball as others.
TEST(MeasuredShape, ItsNoiseIsToldFromReflectivity) {
  FT_NEED_DEVICE();
  constexpr double kSigma = 0.01, kOfVariance = 0.15, kOfTexture = 0.05;
  const std::filesystem::path dir = scratch_folder("measured_shape_texture");
  const ImageF own = texture(kSigma);
  write_exr(dir / "texture.exr", {{"factor", &own}});
  const std::string smoothing = "smoothing_px = 3\nmost_smoothing_px = 3\n";
  const json plain = compared(dir, {.smoothing = smoothing}),
             textured = compared(dir, {.smoothing = smoothing, .texture = "texture.exr"});
  const auto of = [](const json& result, const char* part) {
    return result.at("gray_budget").at(0).at(part).get<double>();
  };
  // what the noise makes of a ball without texture is all that a factor takes
  EXPECT_NEAR(of(plain, "shading_dn2") / of(plain, "albedo_dn2"), 1.0, kOfVariance);
  double squares = 0.0, n = 0.0;
  for (const auto& file : std::filesystem::directory_iterator(dir / "real/left"))
    for (const float dn : read_gray(file.path()).image.data) squares += dn * dn, n += 1.0;
  // values near black, which hold nothing of the texture, are not counted: 12 of the 24 steps are compared
  const double counted = of(textured, "n") / (12.0 * of(textured, "n_pixels")),
               of_texture = kSigma * kSigma * squares / n / counted;
  EXPECT_NEAR((of(textured, "albedo_dn2") - of(textured, "shading_dn2")) / of_texture, 1.0, kOfTexture);
  EXPECT_GT(of(textured, "albedo_dn2"), 1.1 * of_texture) << "the noise counts";
}

TEST(MeasuredShape, ItReachesIntoThePixelsOfItsOutline) {
  FT_NEED_DEVICE();
  // pixels on the outline are measured, and have no points of their own
  EXPECT_EQ(compared(scratch_folder("measured_shape_outline"), {.camera = kWhole})
                .at("budget_verdict")
                .at("coverage"),
            "explained");
}

TEST(MeasuredShape, FringesThatAreNotTheTwinsAreNot) {
  FT_NEED_DEVICE();
  // an amplitude of 1/25 of the fringe, of the order that four of eight steps take for the phase
  EXPECT_EQ(
      compared(scratch_folder("measured_shape_harmonics"), {.fringes = "harmonics = [[0, 0], [0.02, 0]]"})
          .at("budget_verdict")
          .at("phase"),
      "not explained");
}

}  // namespace
}  // namespace fringetwin::testing::measured_shape_test
