// SPDX-License-Identifier: Apache-2.0
// Bad input: one clear sentence (what, where, what to do), the right exit code, nothing left behind that
// looks complete. No tolerances here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::bad_input_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A rendered capture set of the small twin, to be damaged.
class DamagedCapture : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    dir_ = scratch_folder("damaged");
    const RunResult run = render_twin(small_twin(), dir_);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  RunResult measure() {
    return run_fringetwin({"measure", (dir_ / "twin.toml").string(), "--captures", (dir_ / "out").string(),
                           "--out", (dir_ / "measured").string()});
  }
  void expect_no_result() { EXPECT_FALSE(fs::exists(dir_ / "measured" / "result.json")); }
  fs::path image(const std::string& name) { return dir_ / "out" / "left" / name; }
  fs::path dir_;
};

TEST_F(DamagedCapture, UndamagedIsMeasured) {
  const RunResult run = measure();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(dir_ / "measured" / "result.json"));
}

TEST_F(DamagedCapture, MissingImage) {
  fs::remove(image("0003.png"));
  expect_refused(measure(), 3, {"0003.png"});
  expect_no_result();
}

TEST_F(DamagedCapture, TruncatedImage) {
  fs::resize_file(image("0005.png"), fs::file_size(image("0005.png")) / 2);
  expect_refused(measure(), 3, {"0005.png", "truncated"});
  expect_no_result();
}

TEST_F(DamagedCapture, EmptyImage) {
  fs::resize_file(image("0000.png"), 0);
  expect_refused(measure(), 3, {"0000.png"});
  expect_no_result();
}

TEST_F(DamagedCapture, OddSizedImage) {
  const fs::path other = dir_ / "other";
  ASSERT_EQ(render_twin(small_twin({{"[160, 120]", "[150, 120]"}}), other).exit_code, 0);
  fs::copy_file(other / "out" / "left" / "0002.png", image("0002.png"), fs::copy_options::overwrite_existing);
  expect_refused(measure(), 3, {"0002.png", "150", "160"});
  expect_no_result();
}

TEST_F(DamagedCapture, TooManyImages) {
  fs::copy_file(image("0000.png"), image("0012.png"));
  expect_refused(measure(), 3, {"has 13 images on disk, the sequence has 12"});
}

// The names of limits are the comparison's; every command that reads a twin refuses one that is not there.
TEST_F(DamagedCapture, AMisspeltLimitIsRefusedByEveryCommand) {
  const fs::path twin = dir_ / "limits.toml";
  fs::copy_file(dir_ / "twin.toml", twin);
  std::ofstream(twin, std::ios::app) << "\n[limits]\nphase_rms = 1\n";
  const std::string captures = (dir_ / "out").string(), out = (dir_ / "refused").string();
  const std::vector<std::vector<std::string>> commands = {
      {"measure", twin.string(), "--captures", captures, "--out", out},
      {"render", twin.string(), "--out", out},
      {"cosim", twin.string(), "--out", out},
      {"photometry", twin.string(), "--captures", captures, "--out", out}};
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command.front());
    expect_refused(run_fringetwin(command), 2, {"limits.toml:", "did you mean \"phase_rms_rad\"?"});
    EXPECT_FALSE(fs::exists(out));
  }
}

TEST_F(DamagedCapture, NoCaptureToml) {
  fs::remove(dir_ / "out" / "capture.toml");
  expect_refused(measure(), 3, {"capture.toml"});
}

TEST_F(DamagedCapture, UnknownKeyInCaptureToml) {
  std::string text = read_file(dir_ / "out" / "capture.toml");
  const auto at = text.find("pattern");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 7, "patern");
  write_file(dir_ / "out" / "capture.toml", text);
  expect_refused(measure(), 3, {"capture.toml:6: unknown key \"patern\"", "did you mean \"pattern\"?"});
  expect_no_result();
}

TEST(BadTwin, UnknownKeyNamesFileLineAndNearest) {
  const auto dir = scratch_folder("unknown-key");
  expect_refused(render_twin(small_twin({{"radius_mm", "raduis_mm"}}), dir), 2,
                 {"twin.toml:25", "raduis_mm", "radius_mm"});
  EXPECT_FALSE(fs::exists(dir / "out"));
}

TEST(BadTwin, MissingFile) {
  expect_refused(run_fringetwin({"render", "/nonexistent/twin.toml", "--out", "/tmp/never"}), 2,
                 {"/nonexistent/twin.toml"});
}

TEST(BadTwin, BrokenToml) {
  expect_refused(render_twin(small_twin({}, "[unclosed\n"), scratch_folder("broken")), 2, {"twin.toml:30"});
}

TEST(BadTwin, NonInvertibleLens) {
  expect_refused(render_twin(small_twin({{"-0.1, 0.1, 0, 0", "-4.0, 0.0, 0, 0"}}), scratch_folder("lens")), 2,
                 {"twin.toml:7", "camera[0].intrinsics", "cannot be inverted"});
}

TEST(BadTwin, CameraInsideTheObject) {
  FT_NEED_DEVICE();
  expect_refused(render_twin(small_twin({{"radius_mm = 19", "radius_mm = 300"}}), scratch_folder("inside")),
                 2, {"left", "inside", "ball"});
}

TEST(BadTwin, ObjectOutsideTheView) {
  FT_NEED_DEVICE();
  expect_refused(render_twin(small_twin({{"[0, 0, 270]", "[900, 0, 270]"}}), scratch_folder("outside")), 2,
                 {"no camera sees"});
}

TEST(BadTwin, OneOfTwoObjectsOutsideTheViewIsAWarning) {
  FT_NEED_DEVICE();
  const std::string second =
      "[[object]]\nname = \"lost\"\nshape = \"sphere\"\ncenter_mm = [900, 0, 270]\nradius_mm = 5\n"
      "[[measure.fit]]\nobject = \"lost\"\n";
  const auto dir = scratch_folder("one-outside");
  RunResult run = render_twin(small_twin({}, second), dir);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("\"lost\" is outside the view"));
  // A fit with too few points is listed with its n, null values and a warning, exit code 0.
  run = run_fringetwin({"measure", (dir / "twin.toml").string(), "--captures", (dir / "out").string(),
                        "--out", (dir / "m").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto result = read_json(dir / "m" / "result.json");
  ASSERT_EQ(result["fits"].size(), 2u);
  EXPECT_EQ(result["fits"][1]["object"].get<std::string>(), "lost");
  EXPECT_EQ(result["fits"][1]["measured"]["n"].get<int>(), 0);
  EXPECT_TRUE(result["fits"][1]["measured"]["radius_mm"].is_null());
}

TEST(BadTwin, SamplesNotASquare) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("samples");
  write_file(dir / "twin.toml", small_twin());
  expect_refused(run_fringetwin({"render", (dir / "twin.toml").string(), "--out", (dir / "out").string(),
                                 "--sampler", "gauss", "--samples", "5"}),
                 2, {"not 5; choose a square"});
}

TEST(BadMesh, NanVertex) {
  const auto dir = scratch_folder("nan-mesh");
  write_file(dir / "part.obj", "v 0 0 0\nv 10 0 0\nv 0 nan 0\nf 1 2 3\n");
  expect_refused(render_twin(small_twin({{"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19",
                                          "shape = \"mesh\"\nfile = \"part.obj\""}}),
                             dir),
                 3, {"part.obj", "no finite number"});
}

TEST(BadMesh, EmptyMesh) {
  const auto dir = scratch_folder("empty-mesh");
  write_file(dir / "part.ply",
             "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 0\nproperty list uchar int vertex_indices\nend_header\n");
  expect_refused(render_twin(small_twin({{"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19",
                                          "shape = \"mesh\"\nfile = \"part.ply\""}}),
                             dir),
                 3, {"part.ply", "no vertices"});
}

TEST(BadMesh, MissingMesh) {
  expect_refused(render_twin(small_twin({{"shape = \"sphere\"\ncenter_mm = [0, 0, 270]\nradius_mm = 19",
                                          "shape = \"mesh\"\nfile = \"gone.ply\""}}),
                             scratch_folder("missing-mesh")),
                 3, {"gone.ply"});
}

TEST(NoDevice, NoVulkanDriverIsExitCode4) {
  const auto dir = scratch_folder("no-device");
  write_file(dir / "twin.toml", small_twin());
  expect_refused(run_fringetwin({"render", (dir / "twin.toml").string(), "--out", (dir / "out").string()},
                                {"VK_ICD_FILENAMES=/nonexistent.json", "VK_DRIVER_FILES=/nonexistent.json"}),
                 4, {"Vulkan"});
  EXPECT_FALSE(fs::exists(dir / "out" / "capture.toml"));
}

TEST(NoDevice, UnknownDeviceNameListsWhatThereIs) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("other-device");
  write_file(dir / "twin.toml", small_twin());
  expect_refused(run_fringetwin({"render", (dir / "twin.toml").string(), "--out", (dir / "out").string(),
                                 "--device", "NoSuchGPU"}),
                 4, {"NoSuchGPU", "llvmpipe"});
}

// Without the check before the device these were exit code 1 (OpenMP ends the program) and a crash of the
// driver.
TEST(NoDevice, LittleAddressSpaceIsASentence) {
  FT_NEED_DEVICE();
  const auto dir = scratch_folder("addresses");
  write_file(dir / "twin.toml", small_twin());
  const std::string render = "exec '" + std::string(std::getenv("FRINGETWIN_BINARY")) + "' -q render '" +
                             (dir / "twin.toml").string() + "' --out '" + (dir / "out").string() + "' 2>&1";
  for (const int mb : {300, 400, 500, 600, 700, 800}) {
    const auto run =
        testing::run("ulimit -c 0; ulimit -v " + std::to_string(mb << 10) + "; OMP_NUM_THREADS=2 " + render);
    EXPECT_EQ(WEXITSTATUS(run.status), 3) << mb << ": " << run.output;
    EXPECT_THAT(run.output, HasSubstr("fringetwin: error: "));
  }
  EXPECT_FALSE(fs::exists(dir / "out" / "capture.toml"));
}

TEST(Usage, UnknownSubcommandAndOptionAreExitCode2) {
  EXPECT_EQ(run_fringetwin({"frobnicate"}).exit_code, 2);
  EXPECT_EQ(run_fringetwin({}).exit_code, 2);
  EXPECT_EQ(run_fringetwin({"render", "x.toml", "--no-such-option"}).exit_code, 2);
  EXPECT_EQ(run_fringetwin({"--help"}).exit_code, 0);
  EXPECT_EQ(run_fringetwin({"--version"}).exit_code, 0);
}

}  // namespace
}  // namespace fringetwin::testing::bad_input_test
