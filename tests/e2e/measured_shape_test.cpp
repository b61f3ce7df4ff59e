// SPDX-License-Identifier: Apache-2.0
// A ball seen through its own measured shape: a right twin, whose shape has the noise of the steps that it
// was built from, is explained; one whose fringes are not the twin's is not. Limits are the program's own (1
// right row in 370 fails).
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::measured_shape_test {
namespace {

using nlohmann::json;

constexpr const char* kBall = "shape = \"sphere\"\ncenter_mm = [0, 0, 330]\nradius_mm = 60\n";

/// A camera that sees nothing but the ball, and one that sees its outline.
const std::string kInside = "imagersize = [320, 320]\nintrinsics = [2000, 2000, 159.5, 159.5",
                  kWhole = "imagersize = [400, 400]\nintrinsics = [800, 800, 199.5, 199.5";

/// A ball that fills the image (its outline would tell more of windows than of noise), 8 steps, so that even
/// and odd ones tell it by themselves.
std::string twin_of(const std::string& object, const std::string& fringes, const std::string& extra,
                    const std::string& camera = kInside) {
  return small_twin({{"gain_dn = 20", "gain_dn = 15\nelectrons_per_dn = 60\nread_noise_dn = 0.5"},
                     {"imagersize = [160, 120]\nintrinsics = [260, 260, 79.5, 59.5", camera},
                     {"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19\n", object},
                     {"steps = 4", "steps = 8\n" + fringes},
                     {"[[measure.fit]]\nobject = \"ball\"\n", ""}},
                    extra);
}

/// Returns the state of each quantity of a comparison of images with these fringes with the twin, whose have
/// none.
json states_with(const std::string& fringes, const std::filesystem::path& dir,
                 const std::string& camera = kInside) {
  write_file(dir / "truth.toml", twin_of(kBall, fringes, "", camera));
  RunResult run = run_fringetwin(
      {"render", (dir / "truth.toml").string(), "--seed", "11", "--out", (dir / "real").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  write_file(dir / "twin.toml", twin_of("shape = \"measured\"\nsmoothing_px = 4\nmost_smoothing_px = 12\n",
                                        "", "[real]\ncaptures = \"real\"\n", camera));
  run = run_fringetwin({"cosim", (dir / "twin.toml").string(), "--out", (dir / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return read_json(dir / "out/result.json").at("budget_verdict");
}

TEST(MeasuredShape, ARightTwinIsExplained) {
  FT_NEED_DEVICE();
  const json states = states_with("", scratch_folder("measured_shape"));
  EXPECT_EQ(states.at("phase"), "explained");
  EXPECT_EQ(states.at("gray"), "explained");
}

TEST(MeasuredShape, ItReachesIntoThePixelsOfItsOutline) {
  FT_NEED_DEVICE();
  // pixels on the outline are measured, and have no points of their own
  EXPECT_EQ(states_with("", scratch_folder("measured_shape_outline"), kWhole).at("coverage"), "explained");
}

TEST(MeasuredShape, FringesThatAreNotTheTwinsAreNot) {
  FT_NEED_DEVICE();
  // an amplitude of 1/25 of the fringe, of the order that four of eight steps take for the phase
  EXPECT_EQ(
      states_with("harmonics = [[0, 0], [0.02, 0]]", scratch_folder("measured_shape_harmonics")).at("phase"),
      "not explained");
}

}  // namespace
}  // namespace fringetwin::testing::measured_shape_test
