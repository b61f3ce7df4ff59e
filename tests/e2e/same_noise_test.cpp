// SPDX-License-Identifier: Apache-2.0
// A rig whose "real" images this program has rendered with the default seed, as everyone does who tries it
// out: the run's own images must have other noise, or they differ by far less than any noise budget says.
//
// | tolerance | origin |
// |---|---|
// | none | verdicts and seeds |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"

namespace fringetwin::testing::same_noise_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kRig = R"(schema = "fringetwin-twin/1"
name = "a plane"
[[camera]]
name = "left"
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [240, 180]
intrinsics = [400, 400, 119.5, 89.5]
rt_cam_world = [0, 0, 0, 0, 0, 0]
[camera.sensor]
gain_dn = 22.0
electrons_per_dn = 40
read_noise_dn = 0.5
[projector]
lensmodel = "LENSMODEL_PINHOLE"
imagersize = [640, 480]
intrinsics = [900, 900, 319.5, 239.5]
rt_cam_world = [0, 0.3, 0, -80, 0, 12]
intensity = 40.0
[fringes]
directions = ["x"]
pitches_px = [13, 14, 15]
steps = 4
unwrap = "heterodyne"
[[object]]
name = "wall"
shape = "plane"
point_mm = [0, 0, 270]
normal = [0.1, 0, -1]
[object.material]
diffuse = 0.8
[measure]
triangulate = "projector"
[[measure.fit]]
object = "wall"
gate_mm = 2.0
)";

class SameNoise : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    dir_ = scratch_folder("same_noise");
    write_file(dir_ / "truth.toml", kRig);
    write_file(dir_ / "twin.toml", std::string(kRig) + "[real]\ncaptures = \"real\"\n");
    const RunResult run = run_fringetwin({"render", path("truth.toml"), "--out", path("real")});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  std::string path(const std::string& name) const { return (dir_ / name).string(); }
  json result() const { return read_json(dir_ / "out" / "result.json"); }
  fs::path dir_;
};

TEST_F(SameNoise, RenderedImagesAreComparedWithOtherNoise) {
  const RunResult run = run_fringetwin({"cosim", path("twin.toml"), "--out", path("out")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("rendered with seed 0: the simulated ones have seed 1"));
  EXPECT_THAT(run.err, Not(HasSubstr("too wide")));
  EXPECT_EQ(result()["provenance"]["seed"], 1);
  EXPECT_EQ(result()["budget_verdict"]["phase"], "explained");
  EXPECT_THAT(read_file(dir_ / "out" / "report.html"), HasSubstr("the simulated ones have seed 1"));
}

TEST_F(SameNoise, ASeedThatIsAskedForStaysAndIsWarnedOf) {
  const RunResult run = run_fringetwin({"cosim", path("twin.toml"), "--seed", "0", "--out", path("out")});
  EXPECT_THAT(run.err, HasSubstr("--seed 1 gives them another"));
  EXPECT_EQ(result()["provenance"]["seed"], 0);
}

TEST_F(SameNoise, TwoRenderedFoldersOfOneSeedAreWarnedOf) {
  const RunResult run = run_fringetwin(
      {"compare", path("twin.toml"), "--real", path("real"), "--sim", path("real"), "--out", path("out")});
  EXPECT_THAT(run.err, HasSubstr("render one of them with --seed 1"));
}

}  // namespace
}  // namespace fringetwin::testing::same_noise_test
