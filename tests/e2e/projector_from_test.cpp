// SPDX-License-Identifier: Apache-2.0
// calibrate --projector-from: a rig is rendered with its projector, whose description is then thrown away and
// found back from the images, and the twin with what was found explains them.
//
// | check             | tolerance              | origin                                                   |
// |-------------------|------------------------|----------------------------------------------------------|
// | each number       | 4 sigma                | the program's own standard error, wrong once in 16,000   |
// | phase of the twin | chi2, of regions 1.1 x | the program's own limits; a region averages the noise    |
// |                   | its limit              | down to three times what the projector is known to       |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::projector_from_test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Two cameras before two balls and a wall that stands askew.
std::string cameras() {
  std::string out = "schema = \"fringetwin-twin/1\"\nname = \"rig\"\ncameramodel_unit = \"m\"\n";
  for (const auto& [name, x] : {std::pair{"left", -70}, {"right", 70}})
    out += fmt::format(R"([[camera]]
name = "{}"
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [640, 480]
intrinsics = [900, 900, 319.5, 239.5]
position_mm = [{}, 0, 0]
look_at_mm = [0, 0, 400]
[camera.sensor]
gain_dn = 20
electrons_per_dn = 60
read_noise_dn = 0.5
)",
                       name, x);
  return out;
}

constexpr const char* kProjector = R"([projector]
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [800, 600]
intrinsics = [1100, 1090, 420, 330]
rt_cam_world = [-0.06, 0.03, 0.02, 12, 40, 15]
intensity = 40
)";

std::string fringes(const std::string& directions) {
  return "[fringes]\ndirections = " + directions +
         "\npitches_px = [13, 14, 15]\nsteps = 4\nunwrap = \"heterodyne\"\n";
}

constexpr const char* kScene = R"([[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 460]
normal = [0.25, 0.1, -1]
[object.material]
diffuse = 0.7
[[object]]
name = "ball"
shape = "sphere"
center_mm = [-35, -10, 370]
radius_mm = 50
[object.material]
diffuse = 0.8
[[object]]
name = "small"
shape = "sphere"
center_mm = [60, 35, 340]
radius_mm = 35
[object.material]
diffuse = 0.6
)";

constexpr const char* kFlat = R"([[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 400]
normal = [0, 0, -1]
)";

/// Renders the rig into DIR/real and writes DIR/rough.toml, which knows nothing of its projector. Returns the
/// command that solves it.
std::vector<std::string> prepare(const fs::path& dir, const std::string& directions, const std::string& scene,
                                 bool wrong_projector = false) {
  write_file(dir / "truth.toml", cameras() + kProjector + fringes(directions) + scene);
  const RunResult run = run_fringetwin(
      {"render", (dir / "truth.toml").string(), "--seed", "5", "--out", (dir / "real").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  // a projector that is wrong, of which only the size is taken
  std::string wrong = kProjector;
  wrong.replace(wrong.find("420"), 3, "520");
  write_file(dir / "rough.toml", cameras() + (wrong_projector ? wrong : "") + fringes(directions));
  return {"calibrate",  "--projector-from",      (dir / "rough.toml").string(),
          "--captures", (dir / "real").string(), "--imagersize",
          "800x600",    "--lensmodel",           "LENSMODEL_PINHOLE",
          "--out",      (dir / "found").string()};
}

TEST(ProjectorFrom, IsFoundBackAndExplainsTheImages) {
  FT_NEED_DEVICE();
  for (const std::string directions : {"[\"x\", \"y\"]", "[\"x\"]"}) {
    const fs::path dir = scratch_folder("projector_from");
    const RunResult run = run_fringetwin(prepare(dir, directions, kScene, directions == "[\"x\"]"));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json found = read_json(dir / "found/projector.json");
    const json& parameters = found["parameters"];
    const json& sigma = found["sigma"];
    const std::map<std::string, double> truth{{"fx", 1100.0}, {"fy", 1090.0}, {"cx", 420.0}, {"cy", 330.0},
                                              {"r1", -0.06},  {"r2", 0.03},   {"r3", 0.02},  {"t1", 12.0},
                                              {"t2", 40.0},   {"t3", 15.0}};
    for (const auto& [name, value] : truth) {
      if (sigma[name] == 0.0) continue;  // by convention
      EXPECT_NEAR(parameters[name].get<double>(), value, 4.0 * sigma[name].get<double>())
          << name << ' ' << directions;
    }
    // noise of 0.015 px in 36,000 points, of which no more than the tiles' share averages out
    EXPECT_LT(found["column_sigma_px"].get<double>(), 0.001);
    EXPECT_EQ(found["by_convention"].size(), found["rows_decoded"].get<bool>() ? 1U : 4U);
    EXPECT_TRUE(fs::exists(dir / "found/projector_residual.png"));

    write_file(dir / "twin.toml",
               cameras() + "[projector]\nmodel = \"found/projector.cameramodel\"\nintensity = 40\n" +
                   fringes(directions) + kScene + "[real]\ncaptures = \"real\"\n");
    const RunResult cosim =
        run_fringetwin({"cosim", (dir / "twin.toml").string(), "--out", (dir / "out").string()});
    EXPECT_EQ(cosim.exit_code, 0) << cosim.err;
    int rows = 0;
    const json result = read_json(dir / "out/result.json");
    for (const json& row : result.at("explained")) {
      if (row.at("quantity") != "phase") continue;
      ++rows;
      EXPECT_LT(row.at("chi2").get<double>(), row.at("chi2_limit").get<double>())
          << row.at("region") << ' ' << directions;
      EXPECT_LT(row.at("regional_chi2").get<double>(), 1.1 * row.at("regional_limit").get<double>())
          << row.at("region") << ' ' << directions;
    }
    EXPECT_EQ(rows, directions == "[\"x\"]" ? 2 : 4);
  }
}

TEST(ProjectorFrom, WhatCannotBeSolvedIsRefused) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("projector_from_refused");
  std::vector<std::string> command = prepare(dir, "[\"x\"]", kFlat);
  expect_refused(run_fringetwin(command), 3, {"real", "focal length", "several depths"});
  EXPECT_FALSE(fs::exists(dir / "found/projector.json"));
  std::vector<std::string> sizeless(command);
  sizeless.erase(sizeless.begin() + 5, sizeless.begin() + 7);
  expect_refused(run_fringetwin(sizeless), 2, {"--imagersize", "1024x768"});
  std::vector<std::string> board(command);
  board.insert(board.end(), {"--object-spacing", "0.01"});
  expect_refused(run_fringetwin(board), 2, {"--object-spacing", "no board"});
  std::vector<std::string> empty(command);
  empty[6] = "800x0";
  expect_refused(run_fringetwin(empty), 2, {"--imagersize", "800x0"});
  std::string one = cameras();
  one.erase(one.rfind("[[camera]]"));
  write_file(dir / "rough.toml", one + fringes("[\"x\"]"));
  expect_refused(run_fringetwin(command), 2, {"rough.toml", "two calibrated cameras"});
  command.erase(command.begin() + 3, command.begin() + 5);
  expect_refused(run_fringetwin(command), 2, {"--captures", "--projector-from"});
}

}  // namespace
}  // namespace fringetwin::testing::projector_from_test
