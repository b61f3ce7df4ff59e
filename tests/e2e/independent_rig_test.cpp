// SPDX-License-Identifier: Apache-2.0
// Images that another program made stand for the physical ones: the true twin must find gain, black level and
// shapes.
//
// | check                    | tolerance | unit | origin |
// |--------------------------|-----------|------|-------------------------------------------------------------|
// | gain                     | 0.1       | %    | what is asked of the program | | black level              |
// 0.1       | DN   | the same                                                    | | centre, radius, offset
// | 0.002     | mm   | a few sigma of 7000 points of 0.02 mm noise                 | | the same, against
// sigma  | 3         |      | 9 numbers: one of 40 seeds is beyond                        |
#include "tests/e2e/independent_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/e2e/cli_runner.hpp"

namespace fringetwin::test::independent_rig_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json cosim(const std::string& name, const CaptureOptions& captures, const TwinOptions& twin) {
  const fs::path folder = scratch_folder(name);
  write_captures(folder / "real", captures);
  write_file(folder / "twin.toml", twin_toml("real", twin));
  const RunResult run =
      run_fringetwin({"cosim", (folder / "twin.toml").string(), "--out", (folder / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return read_json(folder / "out" / "result.json");
}

void expect_gain(const json& result) {
  const Twin truth = independent_rig();
  ASSERT_EQ(result["gain"].size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    const json& gain = result["gain"][c];
    const Sensor& sensor = truth.cameras[c].sensor;
    EXPECT_NEAR(gain["gain_dn"].get<double>() / sensor.gain_dn, 1.0, 1e-3);
    EXPECT_NEAR(gain["black_level_dn"].get<double>(), sensor.black_level_dn, 0.1);
  }
}

void expect_small(const json& fit, const char* key) {
  EXPECT_LE(std::abs(fit["difference"][key].get<double>()), 0.001) << fit.dump();
  EXPECT_LE(std::abs(fit["z"][key].get<double>()), 3.0) << fit.dump();
}

void expect_shapes(const json& result) {
  ASSERT_EQ(result["fits"].size(), 2u);
  const json& ball = result["fits"][0];
  EXPECT_GT(ball["real"]["n"].get<int>(), 4000);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(std::abs(ball["difference"]["center_mm"][axis].get<double>()), 0.001) << ball.dump();
    EXPECT_LE(std::abs(ball["z"]["center_mm"][axis].get<double>()), 3.0) << ball.dump();
  }
  expect_small(ball, "radius_mm");
  expect_small(result["fits"][1], "offset_mm");
}

TEST(IndependentRig, TheTrueTwinFindsGainAndShapes) {
  FT_NEED_DEVICE();
  FT_NEED_POVRAY();
  const json result = cosim("independent", {}, {});
  expect_gain(result);
  expect_shapes(result);
}

}  // namespace
}  // namespace fringetwin::test::independent_rig_test
