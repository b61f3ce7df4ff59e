// SPDX-License-Identifier: Apache-2.0
// Images that another program made stand for the physical ones: the true twin must find gain, black level and
// shapes of a linear projector, of one with gamma and blur, and with light over a second surface, and its
// budget must explain every difference (rig_causes_test.cpp: wrong twins).
//
// | check                   | tolerance | unit | origin                                            |
// |-------------------------|-----------|------|---------------------------------------------------|
// | gain                    | 0.01      | %    | 1.4 times the largest of the three rigs (0.0071)  |
// | black level             | 0.1       | DN   | 1.5 times the largest (0.066)                     |
// | centre, radius, offset  | 0.001     | mm   | 2.5 times the largest of nine runs (0.0004)       |
// | the same, against sigma | 3         |      | 15 numbers: one seed in 25 is beyond              |
#include "tests/support/program/independent_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/rig_cases.hpp"

namespace fringetwin::testing::independent_rig_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json cosim(const std::string& rig_case) {
  const fs::path folder = write_case(rig_case);
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
    EXPECT_NEAR(gain["gain_dn"].get<double>() / sensor.gain_dn, 1.0, 1e-4);
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

void expect_explained(const json& result) {
  for (const char* quantity : {"gray", "phase", "geometry"})
    EXPECT_EQ(result["budget_verdict"][quantity], "explained") << result["explained"].dump(1);
  EXPECT_TRUE(result["causes"]["named"].is_null());
  EXPECT_TRUE(result["causes"]["tested"].empty());
}

TEST(IndependentRig, TheTrueTwinFindsGainAndShapes) {
  FT_NEED_DEVICE();
  FT_NEED_POVRAY();
  for (const std::string& rig_case : right_cases()) {
    SCOPED_TRACE(rig_case);
    const json result = cosim(rig_case);
    expect_gain(result);
    expect_shapes(result);
    expect_explained(result);
  }
}

}  // namespace
}  // namespace fringetwin::testing::independent_rig_test
