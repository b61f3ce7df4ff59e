// SPDX-License-Identifier: Apache-2.0
// Real captures through the command line. Bounds: what the project asks of each set, and the figures that an
// independent decode reached (README of each folder of captures).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "twin/image/image_io.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::real_captures_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path measure(const std::string& dataset) {
  const fs::path out = scratch_folder("measure-" + dataset);
  const fs::path twin = dataset_twin(dataset);
  const RunResult run = run_fringetwin(
      {"measure", twin.string(), "--captures", twin.parent_path().string(), "--out", out.string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return out;
}

ImageF channel(const fs::path& exr, const std::string& name) {
  for (auto& [channel_name, image] : read_exr(exr))
    if (channel_name == name) return image;
  ADD_FAILURE() << "no channel " << name << " in " << exr;
  return {};
}

double valid_fraction(const ImageF& image) {
  std::size_t n = 0;
  for (const float v : image.data) n += std::isnan(v) ? 0u : 1u;
  return static_cast<double>(n) / static_cast<double>(image.size());
}

TEST(Slmaster, CosimComparesTheOddSteps) {
  FT_NEED_DEVICE();
  FT_NEED_CAPTURES("slmaster-mono-relief");
  const fs::path out = scratch_folder("cosim-slmaster");
  const RunResult run =
      run_fringetwin({"cosim", dataset_twin("slmaster-mono-relief").string(), "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(out / "result.json");
  ASSERT_EQ(result["gain"].size(), 1u);
  EXPECT_LT(result["gain"][0]["rms_after_dn"].get<double>(),
            result["gain"][0]["rms_before_dn"].get<double>());
  for (const json& row : result["gray"])  // odd steps only, no Gray-code image
    EXPECT_THAT(row["pattern"].get<std::string>(), ::testing::Not(::testing::HasSubstr("gray")));
  EXPECT_EQ(result["gray"].size(), 6u);
  ASSERT_EQ(result["phase"].size(), 1u);
  // Even-step phase noise 0.0188 sqrt(2) smoothed away, odd-step noise 0.0188 sqrt(2) left, plus harmonics.
  EXPECT_LT(result["phase"][0]["rms_rad"].get<double>(), 0.1);
  const std::string html = read_file(out / "report.html");
  EXPECT_THAT(html, ::testing::HasSubstr("even"));
  EXPECT_LE(html.size(), 8'000'000u);  // a page that can be mailed
  // What the surface's colour, the projector's contrast and noise do to the images: 284 of 300 DN² measured.
  ASSERT_EQ(result["gray_budget"].size(), 1u);
  const json& budget = result["gray_budget"][0];
  const auto part = [&](const char* name) { return budget[name].get<double>(); };
  EXPECT_GE(part("noise_dn2") + part("albedo_dn2") + part("harmonics_dn2"), 0.8 * part("total_dn2"));
  EXPECT_LE(part("noise_dn2") + part("albedo_dn2") + part("harmonics_dn2"), 1.05 * part("total_dn2"));
  EXPECT_GT(part("noise_dn2"), 1.0);  // measured on the images: 4.0
  // The twin's surface has one colour, the real one has not: the budget must not call that explained.
  EXPECT_EQ(result["budget_verdict"]["gray"], "not explained");
}

// Its shape without the ripples of the fringes' harmonics, its light and what each pixel has of its own
// refined. Limits: 1.3 times the noise is what is wanted of a twin (1.25 measured; a free fit of mean,
// amplitude and phase of every pixel leaves 1.24 ... 1.44); the ripple was 0.0114 rad rms with the shape as
// its steps show it, and is to be a third.
TEST(Slmaster, RefinedImagesAreHeldOutAndTheRippleIsGone) {
  FT_NEED_CAPTURES("slmaster-mono-relief");
  const fs::path out = scratch_folder("cosim-slmaster-refined");
  const RunResult run =
      run_fringetwin({"cosim", dataset_twin("slmaster-mono-relief").string(), "--hold-out", "3", "--refine",
                      "exposure,harmonics,texture,offset", "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(out / "result.json");
  double left = 0.0, predicted = 0.0;
  for (const json& row : result["held_out"]) {
    const auto n = row["n"].get<double>();
    left += n * std::pow(row["rms_dn"].get<double>(), 2);
    predicted +=
        n * (std::pow(row["noise_dn"].get<double>(), 2) + std::pow(row["fitted_dn"].get<double>(), 2));
  }
  ASSERT_EQ(result["held_out"].size(), 12u);
  EXPECT_LE(std::sqrt(left / predicted), 1.3);
  const json& refinement = result["refinement"];  // 2.86 -> 1.43; taken back it would stay
  EXPECT_LT(refinement["chi2_after"].get<double>(), 0.7 * refinement["chi2_before"].get<double>());
  EXPECT_LE(std::sqrt(result["phase_budget"][0]["harmonic_rad2"].get<double>()), 0.0114 / 3.0);
  EXPECT_EQ(result["gain"][0]["state"], "not offered") << "it was held";
}

// Two of its twelve images have 3 % less light than the rest, as the refinement of each exposure finds, too
// (datasets/README.md); 1.5 % tells them apart from the others.
TEST(Slmaster, LightOfTheImagesIsKnownToAThousandth) {
  FT_NEED_CAPTURES("slmaster-mono-relief");
  const fs::path out = scratch_folder("photometry-slmaster");
  const RunResult run =
      run_fringetwin({"photometry", dataset_twin("slmaster-mono-relief").string(), "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json light = read_json(out / "photometry.json")["cameras"][0]["light"];
  for (std::size_t k = 0; k < 12; ++k) {
    EXPECT_LE(light["factor_sigma"][k].get<double>(), 1e-3) << k;
    EXPECT_NEAR(light["factor"][k].get<double>(), k == 5 || k == 10 ? 0.971 : 1.0, k == 0 ? 0.035 : 0.015)
        << k;
  }
}

TEST(Slmaster, MeasuredPoints) {
  FT_NEED_CAPTURES("slmaster-mono-relief");
  const fs::path out = measure("slmaster-mono-relief");
  const ImageF column = channel(out / "phase_camera.exr", "column_px");
  EXPECT_GE(valid_fraction(column) * 1280 * 1024, 195000);
  const ImageF sigma = channel(out / "phase_camera.exr", "sigma_rad");
  EXPECT_EQ(sigma.width, 1280);
}

TEST(Slsdk, LeftPixelsTriangulated) {
  FT_NEED_CAPTURES("slsdk-stereo-statue");
  const fs::path out = measure("slsdk-stereo-statue");
  const json result = read_json(out / "result.json");
  EXPECT_GE(result["triangulation"]["n_points"].get<double>() / (2048.0 * 1536.0), 0.48);
}

TEST(Slsdk, TheProjectorIsSolvedFromTheShape) {
  FT_NEED_CAPTURES("slsdk-stereo-statue");
  const fs::path set = dataset_twin("slsdk-stereo-statue").parent_path(),
                 out = scratch_folder("slsdk_projector");
  // the cameras and fringes of twin-rig.toml, without what was solved before
  std::ifstream in(set / "twin-rig.toml");
  std::string rig(std::istreambuf_iterator<char>(in), {});
  const auto from = rig.find("[projector]"), to = rig.find("[fringes]");
  ASSERT_LT(from, to);
  rig.erase(from, to - from);
  const fs::path rough = scratch_folder("slsdk_rough") / "rough.toml";
  write_file(rough, rig);
  const RunResult run = run_fringetwin({"calibrate", "--projector-from", rough.string(), "--captures",
                                        set.string(), "--imagersize", "1024x768", "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json found = read_json(out / "projector.json");
  // an independent decode finds phase noise of 0.038 rad; 1.3 times as much, with the scatter of the points
  EXPECT_LT(found["chi2"].get<double>(), 1.3 * 1.3);
  // what noise makes of tiles is 0.048; a lens without distortion leaves 0.175
  EXPECT_LT(found["tile_rms_px"].get<double>(), 0.09);
  // the twin of the set has these numbers
  const Twin twin = load_twin(set / "twin-rig.toml");
  for (const auto& [name, k] : {std::pair{"fx", 0}, {"cx", 2}, {"k1", 4}})
    EXPECT_NEAR(found["parameters"][name].get<double>(), twin.projector->lens.intrinsics()[k],
                found["sigma"][name].get<double>())
        << name;
}

TEST(Slsdk, TheTwinWithBouncesIsOfTheSameRig) {
  FT_NEED_CAPTURES("slsdk-stereo-statue");
  const fs::path set = dataset_twin("slsdk-stereo-statue").parent_path();
  const Twin rig = load_twin(set / "twin-rig.toml"), bounces = load_twin(set / "twin-bounces.toml");
  EXPECT_EQ(bounces.projector->lens.intrinsics(), rig.projector->lens.intrinsics());
  EXPECT_EQ(bounces.projector->T_proj_world.translation_mm, rig.projector->T_proj_world.translation_mm);
  EXPECT_EQ(bounces.projector->T_proj_world.rotation, rig.projector->T_proj_world.rotation);
  ASSERT_EQ(bounces.cameras.size(), rig.cameras.size());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    EXPECT_EQ(bounces.cameras[c].lens.intrinsics(), rig.cameras[c].lens.intrinsics());
    EXPECT_EQ(bounces.cameras[c].T_cam_world.translation_mm, rig.cameras[c].T_cam_world.translation_mm);
  }
  EXPECT_EQ(bounces.render.bounces, kAllBounces);
}

TEST(Cpsd, DecodesEveryFrequency) {
  FT_NEED_CAPTURES("cpsd-plane-4freq12step");
  const fs::path out = measure("cpsd-plane-4freq12step");
  const ImageF column = channel(out / "phase_camera.exr", "column_px");
  EXPECT_GT(valid_fraction(column), 0.9);
  EXPECT_EQ(channel(out / "phase_camera.exr", "wrapped_x_1").width, 900);
}

TEST(Kamino, DecodesBothAxes) {
  FT_NEED_CAPTURES("kamino-procam-board");
  const fs::path out = measure("kamino-procam-board");
  const ImageF column = channel(out / "phase_camera.exr", "column_px");
  const ImageF row = channel(out / "phase_camera.exr", "row_px");
  ImageF both = column;
  for (std::size_t i = 0; i < both.size(); ++i)
    if (std::isnan(row.data[i])) both.data[i] = row.data[i];
  EXPECT_GE(valid_fraction(both), 0.45);
  EXPECT_LE(valid_fraction(both), 0.57);  // the README rounds to whole per cents
}

// A code alone, on a sheet that bulges, by a projector with a halo: each pixel's own factor and offset
// refined, what is left is noise. Limit: that of the verdict; 1.01 was measured, 5 without the halo. The page
// says "not compared" of the whole image: the sheet is a fourth of what is lit.
TEST(Kamino, OnTheBoardNoiseIsLeft) {
  FT_NEED_CAPTURES("kamino-procam-board");
  const fs::path out = scratch_folder("cosim-kamino-board");
  const fs::path twin = dataset_twin("kamino-procam-board").parent_path() / "twin-board.toml";
  const RunResult run =
      run_fringetwin({"cosim", twin.string(), "--refine", "texture,offset", "--out", out.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(out / "result.json");
  const auto& rows = result["explained"];
  const auto gray = std::ranges::find_if(rows, [](const json& row) { return row["quantity"] == "gray"; });
  ASSERT_NE(gray, rows.end());
  EXPECT_GT((*gray)["n"].get<double>(), 400'000);
  EXPECT_LT((*gray)["chi2"].get<double>(), (*gray)["chi2_limit"].get<double>());
  EXPECT_GT((*gray)["chi2"].get<double>(), (*gray)["chi2_least"].get<double>());
}

}  // namespace
}  // namespace fringetwin::testing::real_captures_test
