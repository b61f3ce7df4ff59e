// SPDX-License-Identifier: Apache-2.0
// The program itself records from the kernel's driver in a virtual machine, undisturbed, with frames lost and
// corrupt, and with a camera unplugged; the sets are then this machine's: exact, verified, measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/device/pattern.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "twin/image/image_io.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::capture_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* vivid =
    "vivid n_devs=3 node_types=0x101,0x101,0x101 num_inputs=1,1,1 num_outputs=1,1,1 input_types=0x3,0x3,0x3 "
    "output_types=0x1,0x1,0x1 multiplanar=1,1,1";

fs::path binary() { return std::getenv("FRINGETWIN_BINARY"); }
fs::path vm_folder() { return fs::path(std::getenv("FRINGETWIN_SOURCE")) / "tests" / "vm"; }

struct GuestRun {
  int exit_code = -1;
  std::string said;
};

GuestRun run_guest(const fs::path& out) {
  const fs::path build = binary().parent_path();
  fs::create_directories(out);
  fs::copy_file(vm_folder() / "loop_twin.toml", out / "twin.toml");
  const std::string command = "'" + (vm_folder() / "run_in_vm.sh").string() + "' '" + out.string() +
                              "' --cache '" + build.string() + "' --root --memory 1500 --load '" + vivid +
                              "' --program '" + (build / "tests" / "vivid_control").string() +
                              "' --program '" + (vm_folder() / "guest_capture.sh").string() +
                              "' -- guest_capture.sh '" + binary().string() + "' >'" +
                              (out / "said.txt").string() + "' 2>&1";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, read_file(out / "said.txt")};
}

class VmCapture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    out_ = scratch_folder("vm_capture");
    guest_ = run_guest(out_);
    std::printf("%s\n", guest_.said.c_str());
  }
  void SetUp() override {
    if (guest_.exit_code == 77) GTEST_SKIP() << "SKIPPED: " << guest_.said;
    ASSERT_EQ(guest_.exit_code, 0) << guest_.said;
  }
  static fs::path out_;
  static GuestRun guest_;
};
fs::path VmCapture::out_;
GuestRun VmCapture::guest_;

// Each image has the values that were sent to the projector.
void expect_exact(const fs::path& set) {
  const Twin twin = load_twin(vm_folder() / "loop_twin.toml");
  const auto patterns = capture::sequence_patterns(twin.fringes);
  ASSERT_EQ(patterns.size(), 9u);
  for (const Camera& camera : twin.cameras)
    for (const capture::Pattern& pattern : patterns) {
      const capture::ImageU16 sent =
          capture::quantise_levels(capture::pattern_levels(twin.fringes, pattern, 1280, 720), 12);
      const fs::path file = set / camera.name / fmt::format("{:04}.png", pattern.index);
      const ImageF got = read_gray(file).image;
      EXPECT_TRUE(std::equal(sent.data.begin(), sent.data.end(), got.data.begin(), got.data.end())) << file;
    }
}

TEST_F(VmCapture, EverySetIsExactAndVerified) {
  for (const char* set : {"plain", "broken", "disturbed"}) {
    expect_exact(out_ / set);
    const RunResult verified = run_fringetwin(
        {"capture", (vm_folder() / "loop_twin.toml").string(), "--verify", (out_ / set).string()});
    EXPECT_EQ(verified.exit_code, 0) << set << ": " << verified.out << verified.err;
  }
}

// Gaps of the cameras' own count within a pattern.
int lost_frames(const fs::path& csv) {
  std::istringstream lines(read_file(csv));
  std::map<std::string, long> last;  // by step and camera
  int lost = 0;
  std::string line;
  for (std::getline(lines, line); std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    const std::string key = cells.at(0) + " " + cells.at(2) + " " + cells.at(4);  // step, showing, camera
    const long sequence = std::stol(cells.at(5));
    if (const auto before = last.find(key); before != last.end() && sequence > before->second)
      lost += static_cast<int>(sequence - before->second) - 1;
    last[key] = sequence;
  }
  return lost;
}

TEST_F(VmCapture, WhatWasDisturbedIsSaid) {
  EXPECT_THAT(guest_.said, HasSubstr("recorded 9 of 9 patterns"));
  EXPECT_THAT(guest_.said, HasSubstr("frames lost 0, repeated 0, corrupt 0"));
  EXPECT_THAT(guest_.said, ::testing::ContainsRegex("[1-9][0-9]* tried again\nfringetwin: the cameras"));
  EXPECT_THAT(guest_.said, HasSubstr("no signal"));
  EXPECT_THAT(read_file(out_ / "broken" / "frames.csv"), HasSubstr("given up"));
  EXPECT_THAT(read_file(out_ / "disturbed" / "frames.csv"), HasSubstr("error flag"));
  EXPECT_GT(lost_frames(out_ / "disturbed" / "frames.csv"), 0);
  EXPECT_EQ(lost_frames(out_ / "plain" / "frames.csv"), 0);
  EXPECT_THAT(guest_.said, ::testing::ContainsRegex("/dev/video[23] is gone; [1-9] of 9 patterns are kept"));
  EXPECT_THAT(read_file(out_ / "before_resume.txt"), HasSubstr("0005.png"));
  EXPECT_THAT(read_file(out_ / "list.txt"), HasSubstr("/dev/video0: vivid"));
}

// The loop is what a plane at 600 mm would look like (loop_twin.toml).
TEST_F(VmCapture, MeasuredOnThisMachineItIsThePlane) {
  const RunResult run = run_fringetwin({"measure", (vm_folder() / "loop_twin.toml").string(), "--captures",
                                        (out_ / "plain").string(), "--out", (out_ / "measured").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto fit = read_json(out_ / "measured" / "result.json").at("fits").at(0).at("measured");
  EXPECT_GT(fit.at("n").get<int>(), 200000);
  // Both cameras have the same values, so their phases agree to rounding.
  EXPECT_NEAR(fit.at("point_mm").at(2).get<double>(), 600.0, 1e-6);
  EXPECT_NEAR(std::abs(fit.at("normal").at(2).get<double>()), 1.0, 1e-9);
  EXPECT_LT(fit.at("rms_mm").get<double>(), 1e-6);
}

}  // namespace
}  // namespace fringetwin::testing::capture_test
