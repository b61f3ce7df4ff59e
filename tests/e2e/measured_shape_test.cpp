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

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/twin/save_mesh_ply.hpp"
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
  Replacements of_truth = {};             ///< in the truth alone
  std::string object = kBall;             ///< in the truth
  std::vector<std::string> options = {};  ///< of the comparison
};

/// Returns what a comparison says of images with these fringes and this texture with the twin, which has
/// none.
json compared(const std::filesystem::path& dir, const Run& r) {
  const std::string with_texture =
      r.texture.empty() ? r.camera : "texture = \"" + r.texture + "\"\n" + r.camera;
  Replacements rig = r.rig;
  rig.insert(rig.end(), r.of_truth.begin(), r.of_truth.end());
  write_file(dir / "truth.toml", twin_of(r.object, r.fringes, "", with_texture, rig));
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

/// Writes a sheet that faces the camera, 270 mm away, with this height towards it, mm, over the pixels of the
/// camera. Returns the object of the twin.
std::string sheet(const std::string& name, const std::function<double(double x_mm, double y_mm)>& height_mm) {
  constexpr int kSide = 700;
  constexpr double kHalf_mm = 25.0, kStep_mm = 2.0 * kHalf_mm / (kSide - 1);
  Mesh mesh;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const Eigen::Vector2d at_mm(kStep_mm * x - kHalf_mm, kStep_mm * y - kHalf_mm);
      mesh.vertices_mm.push_back(
          Eigen::Vector3d(at_mm.x(), at_mm.y(), 270.0 - height_mm(at_mm.x(), at_mm.y())).cast<float>());
    }
  for (int y = 0; y + 1 < kSide; ++y)
    for (int x = 0; x + 1 < kSide; ++x) {
      const int i = y * kSide + x;
      mesh.triangles.push_back({i, i + kSide + 1, i + 1});
      mesh.triangles.push_back({i, i + kSide, i + kSide + 1});
    }
  const std::filesystem::path file = scratch_folder("measured_shape_of_" + name) / "sheet.ply";
  save_mesh_ply(file, mesh);
  return "shape = \"mesh\"\nfile = \"" + file.string() + "\"\n";
}

/// Waves of 5 mm (37 px), and folds with creases 4 mm apart, both aslant.
double wave_mm(double x_mm, double y_mm) {
  return 0.3 * std::sin(2.0 * std::numbers::pi * (0.8 * x_mm + 0.6 * y_mm) / 5.0);
}
double folds_mm(double x_mm, double y_mm) {
  const double at = (0.8 * x_mm + 0.6 * y_mm) / 8.0;
  return 0.8 * (2.0 * std::abs(2.0 * (at - std::floor(at + 0.5))) - 1.0);
}

/// Returns the row of a quantity among those of a verdict.
json row_of(const json& result, const std::string& quantity) {
  for (const json& row : result.at("explained"))
    if (row.at("quantity") == quantity) return row;
  return {};
}

// A mesh of a vertex per pixel lies beside a surface that bends: were the vertices on the surface, a pixel's
// mean would see the fringes elsewhere (chi2 of regions of the phase was 1.7 on all of these). Gray values
// see slopes, which windows smooth.
TEST(MeasuredShape, AFormThatBendsIsExplainedInPhase) {
  FT_NEED_DEVICE();
  const std::string wave = sheet("wave", wave_mm), folds = sheet("folds", folds_mm);
  const std::string fine = "smoothing_px = 2\n", wide = "smoothing_px = 4\n";
  for (const auto& [object, smoothing] :
       {std::pair{wave, fine}, std::pair{wave, wide}, std::pair{folds, fine}, std::pair{folds, wide}}) {
    const json phase = row_of(
        compared(scratch_folder("measured_shape_form"), {.smoothing = smoothing, .object = object}), "phase");
    EXPECT_EQ(phase.at("state"), "explained") << smoothing << phase.dump();
    EXPECT_GT(phase.at("regional_chi2").get<double>(), 0.7) << smoothing << phase.dump();
  }
}

/// Returns the result of a run that looks for causes.
json with_causes(const Run& r) {
  const json result = compared(scratch_folder("measured_shape_causes"), r);
  EXPECT_FALSE(result.at("causes").at("tested").empty()) << result.at("explained").dump();
  return result;
}

// Windows of 4 px round creases off. That is told of the gray values (before, a texture, a pose or gloss was
// named), but not of a rig whose projector blurs, or of a ball: what differs there does not follow what
// windows do.
TEST(MeasuredShape, WindowsThatSmoothAFormAwayAreTold) {
  FT_NEED_DEVICE();
  const std::string folds = sheet("folds", folds_mm), wide = "smoothing_px = 4\n";
  const auto told = [](const json& result) {
    return row_of(result, "gray").dump().find("smooth away") != std::string::npos;
  };
  const json smoothed =
      compared(scratch_folder("measured_shape_smoothed"), {.smoothing = wide, .object = folds});
  EXPECT_TRUE(told(smoothed)) << row_of(smoothed, "gray").dump();
  EXPECT_TRUE(smoothed.at("causes").at("tested").empty()) << smoothed.at("causes").dump();
  for (const std::string blur_px : {"1", "2"}) {
    const Replacements blur{{"intensity = 40", "intensity = 40\nblur_px = " + blur_px}};
    EXPECT_FALSE(told(with_causes({.smoothing = wide, .of_truth = blur, .object = folds}))) << blur_px;
    EXPECT_FALSE(told(with_causes({.smoothing = wide, .of_truth = blur}))) << blur_px;
  }
  // beside fringes that the phase shows to be others, smoothing is told, but is not all
  with_causes({.fringes = "harmonics = [[0, 0], [0.02, 0]]", .smoothing = wide, .object = folds});
}

// Nothing of what lies behind a step is taken for what the windows in front of it smooth away: the phase's
// budget would be so wide that it told nothing.
TEST(MeasuredShape, StepsWidenNoBudget) {
  FT_NEED_DEVICE();
  const std::string steps = sheet("steps", [](double x_mm, double y_mm) {
    return std::fmod(std::floor((x_mm + 0.2 * y_mm) / 9.0) + 8.0, 2.0) * 20.0;
  });
  const json phase = row_of(
      compared(scratch_folder("measured_shape_steps"), {.smoothing = "smoothing_px = 4\n", .object = steps}),
      "phase");
  EXPECT_EQ(phase.at("state"), "explained") << phase.dump();
  EXPECT_GT(phase.at("chi2").get<double>(), 0.95) << phase.dump();
  EXPECT_GT(phase.at("regional_chi2").get<double>(), 0.8) << phase.dump();
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
