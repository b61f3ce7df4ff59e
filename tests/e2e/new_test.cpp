// SPDX-License-Identifier: Apache-2.0
// new: what it writes is a twin as asked for, and the commands it prints measure its ball.
//
// | check          | tolerance | unit | origin                                                             |
// |----------------|-----------|------|--------------------------------------------------------------------|
// | places         | 1e-9      | mm   | rounding of a pose and its inverse at 250 mm                       |
// | width seen     | 0.1       | mm   | the focal length is written to 0.1 px of 1280                      |
// | white          | 1         | DN   | intensity is written as a whole number                             |
// | radius         | 4 sigma   | mm   | the fit's own standard error, wrong once in 16,000; the mean over  |
// |                |           |      | a pixel's area is taken off as the program states it (method_bias)  |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "tests/support/program/small_twin.hpp"
#include "tests/support/twin/model_in_metres.hpp"
#include "twin/lens/lens.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::new_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

fs::path folder(const std::string& name) {
  const fs::path dir = fs::temp_directory_path() / ("fringetwin_new_" + name);
  fs::remove_all(dir);
  return dir;
}

/// Runs the commands that `new` has printed, and returns how many went well.
int run_printed(const RunResult& made) {
  std::istringstream lines(made.out);
  int commands = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word != "fringetwin") continue;
    std::vector<std::string> arguments;
    while (words >> word) arguments.push_back(word);
    if (arguments.front() == "measure") arguments.emplace_back("--method-bias");
    const RunResult run = run_fringetwin(arguments);
    EXPECT_EQ(run.exit_code, 0) << line << run.err;
    commands += run.exit_code == 0 ? 1 : 0;
  }
  return commands;
}

TEST(New, TheRigIsAsAskedFor) {
  const fs::path dir = folder("two");
  const RunResult run =
      run_fringetwin({"new", "--out", dir.string(), "--camera", "1.3MP", "--cameras", "2", "--distance",
                      "300", "--baseline", "120", "--projector", "1920x1080"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Twin twin = load_twin(dir / "twin.toml");
  ASSERT_EQ(twin.cameras.size(), 2u);
  const auto stands = [](const Pose& T) { return T.inverse().translation_mm; };
  const Eigen::Vector3d target(0, 0, 300);
  EXPECT_EQ(twin.cameras[0].T_cam_world.translation_mm.norm(), 0.0);
  EXPECT_LT((stands(twin.cameras[1].T_cam_world) - Eigen::Vector3d(120, 0, 0)).norm(), 1e-9);
  EXPECT_LT((stands(twin.projector->T_proj_world) - Eigen::Vector3d(60, 0, 0)).norm(), 1e-9);
  for (const Pose& T : {twin.cameras[1].T_cam_world, twin.projector->T_proj_world})
    EXPECT_LT((T * target).head<2>().norm(), 1e-9);
  EXPECT_NEAR(1280.0 * 300.0 / twin.cameras[0].lens.intrinsics()[0], 150.0, 0.1);
  EXPECT_NEAR(twin.projector->intensity * 0.8 / std::numbers::pi, 0.8 * 255.0, 1.0);
  // unambiguous over 1920 px: checked by the reader, too
  EXPECT_GE(twin.fringes.directions[0].pitches_px[0], 14.0);
}

TEST(New, AsksForNoFolder) {
  const fs::path here = folder("here");
  fs::create_directories(here);
  const RunResult run =
      run_fringetwin({"new", "--camera", "5MP", "--distance", "250", "--baseline", "100", "--ball", "30"},
                     {"-C", here.string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  ASSERT_TRUE(fs::exists(here / "rig" / "twin.toml")) << run.out;
  const Twin twin = load_twin(here / "rig" / "twin.toml");
  const auto& ball = std::get<SphereShape>(twin.objects[0].shape);
  EXPECT_EQ(ball.radius_mm, 15.0);
  EXPECT_EQ(ball.center_mm, Eigen::Vector3d(0, 0, 265)) << "its front is at the distance";
}

TEST(New, WhatIsThereIsNotOverwritten) {
  const fs::path dir = folder("mine");
  write_file(dir / "twin.toml", "mine\n");
  const RunResult run = run_fringetwin({"new", "--out", dir.string()});
  expect_refused(run, 2, {"twin.toml: exists"});
  std::ifstream in(dir / "twin.toml");
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "mine");
  for (const char* size : {"5", "4MP", "100000x10", "0x0"})
    expect_refused(run_fringetwin({"new", "--out", folder("bad").string(), "--camera", size}), 2,
                   {"--camera", "is no size"});
}

TEST(New, ThePrintedCommandsMeasureTheBall) {
  const fs::path dir = folder("small");
  const RunResult made = run_fringetwin({"new", "--out", dir.string(), "--camera", "320x256"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(run_printed(made), 2);
  std::ifstream in(dir / "measured" / "result.json");
  const nlohmann::json fit = nlohmann::json::parse(in).at("fits").at(0);
  const Twin twin = load_twin(dir / "twin.toml");
  const double radius = std::get<SphereShape>(twin.objects[0].shape).radius_mm;
  const double found = fit.at("measured").at("radius_mm").get<double>(),
               bias = fit.at("method_bias").at("radius_mm").get<double>(),
               sigma = fit.at("measured").at("radius_sigma_mm").get<double>();
  EXPECT_NEAR(found - bias, radius, 4.0 * sigma) << fit.dump(1);
}

/// Writes a device of a twin as a calibration would, in metres.
std::string written_model(const fs::path& file, const Lens& lens, const Pose& T_device_world) {
  fs::create_directories(file.parent_path());
  write_model_in_metres(file, lens, T_device_world);
  return file.string();
}

// The axes of the devices meet at 300 mm, where the ball begins; the models stay where they are.
TEST(New, OfACalibrationItHasItsDevices) {
  const fs::path dir = folder("calibrated"), models = dir / "models \"1\"", rig = dir / "rig";
  ASSERT_EQ(run_fringetwin({"new", "--out", (dir / "drawn").string(), "--camera", "320x256", "--cameras", "2",
                            "--distance", "300", "--baseline", "120", "--projector", "1920x1080"})
                .exit_code,
            0);
  const Twin drawn = load_twin(dir / "drawn" / "twin.toml");
  const std::string left = written_model(models / "left.cameramodel", drawn.cameras[0].lens, Pose{}),
                    right = written_model(models / "right.cameramodel", drawn.cameras[1].lens,
                                          drawn.cameras[1].T_cam_world),
                    projector = written_model(models / "beamer.cameramodel", drawn.projector->lens,
                                              drawn.projector->T_proj_world);
  const RunResult made =
      run_fringetwin({"new", "--from", left, right, "--from-projector", projector, "--out", rig.string()});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Twin twin = load_twin(rig / "twin.toml");
  ASSERT_EQ(twin.cameras.size(), 2u);
  EXPECT_EQ(twin.cameras[1].name, "right");
  EXPECT_EQ(twin.cameras[1].lens.intrinsics(), drawn.cameras[1].lens.intrinsics());
  EXPECT_LT((twin.cameras[1].T_cam_world.translation_mm - drawn.cameras[1].T_cam_world.translation_mm).norm(),
            1e-9);
  EXPECT_LT(
      (twin.projector->T_proj_world.translation_mm - drawn.projector->T_proj_world.translation_mm).norm(),
      1e-9);
  EXPECT_EQ(twin.fringes.directions[0].pitches_px, drawn.fringes.directions[0].pitches_px);
  const auto ball = [](const Twin& of) { return std::get<SphereShape>(of.objects.at(0).shape); };
  EXPECT_LT((ball(twin).center_mm - ball(drawn).center_mm).norm(), 0.02) << "written to 0.01 mm";
  EXPECT_NEAR(ball(twin).radius_mm, ball(drawn).radius_mm, 0.1);
  EXPECT_EQ(run_printed(made), 2);

  const RunResult nearer =
      run_fringetwin({"new", "--from", right, "--distance", "200", "--out", (dir / "nearer").string()});
  ASSERT_EQ(nearer.exit_code, 0) << nearer.err;
  EXPECT_THAT(nearer.out, HasSubstr("--captures CAPTURES")) << "nothing is rendered without a projector";
  const Twin seen = load_twin(dir / "nearer" / "twin.toml");
  EXPECT_FALSE(seen.projector);
  const Eigen::Vector3d in_camera = seen.cameras[0].T_cam_world * ball(seen).center_mm;
  EXPECT_LT((in_camera - Eigen::Vector3d(0, 0, 200 + ball(seen).radius_mm)).norm(), 0.02);
}

TEST(New, NamesModelsFromARelativeFolder) {
  const fs::path dir = folder("relative_models"), here = fs::current_path();
  const std::string left = written_model(
      dir / "left.cameramodel", Lens("LENSMODEL_PINHOLE", {300, 300, 80, 60}, {160, 120}, "lens"), {});
  fs::current_path(dir);
  const RunResult run = run_fringetwin({"new", "--from", "left.cameramodel", "--out", "rig"});
  fs::current_path(here);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(load_twin(dir / "rig" / "twin.toml").cameras.at(0).lens.width(), 160);
}

TEST(New, OfWhatIsNoModelItSaysWhatToDo) {
  const fs::path dir = folder("no_models");
  const std::string left = written_model(
      dir / "left.cameramodel", Lens("LENSMODEL_PINHOLE", {300, 300, 80, 60}, {160, 120}, "lens"), {});
  const auto made_from = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"new", "--out", (dir / "rig").string(), "--from"});
    return run_fringetwin(arguments);
  };
  expect_refused(made_from({(dir / "calib.yml").string()}), 2,
                 {"calib.yml: is no .cameramodel", "fringetwin import"});
  expect_refused(made_from({left, "--from-projector", "p.xml"}), 2,
                 {"--from-projector p.xml: is no .camera"});
  expect_refused(made_from({(dir / "none.cameramodel").string()}), 3, {"none.cameramodel"});
  expect_refused(made_from({left, "--camera", "5MP"}), 2, {"--camera"});
  expect_refused(made_from({left, left}), 2, {"left.cameramodel: another device is named \"left\", too"});
  EXPECT_FALSE(fs::exists(dir / "rig"));
}

}  // namespace
}  // namespace fringetwin::testing::new_test
