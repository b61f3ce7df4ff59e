// SPDX-License-Identifier: Apache-2.0
// `fringetwin capture` as a user runs it, on a rig made of a twin: the loop rig -> capture -> twin -> report
// closes, and a program killed at any moment leaves a whole set or one that can be resumed.
//
// | check                           | tolerance | origin |
// |---------------------------------|-----------|------------------------------------------------------------|
// | cosim of the captured twin      | explained | its own budget (docs/METRICS.md), 99.9 % limits, seed fixed
// | | noise-free frames               | 0         | the same light through the same sensor as `render` | |
// electrons per DN, read noise    | 4 sigma   | put into the twin; photometry's own sigma                  |
// | phase noise of dark parts       | < 1/3     | 16 times the light: 4 times less relative shot noise, more
// | |                                 |           | where reading and rounding count |
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "capture/record/journal.hpp"
#include "capture/record/verify_set.hpp"
#include "tests/support/program/capture_killed.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::capture_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kNoise =
    "gain_dn = 20\nexposure_ms = 10\nelectrons_per_dn = 40\nread_noise_dn = 0.8\nblack_level_dn = 8";

std::string noisy_twin(const std::string& extra = "") {
  return small_twin({{"gain_dn = 20", kNoise}}, extra);
}

/// Records the twin's own rig.
RunResult capture(const fs::path& twin, const fs::path& out, std::vector<std::string> more = {}) {
  more.insert(more.begin(),
              {"capture", twin.string(), "--camera", "twin:" + twin.string(), "--out", out.string()});
  return run_fringetwin(more);
}

TEST(CaptureCommand, RehearsalClosesTheLoop) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_loop");
  write_file(dir / "twin.toml", noisy_twin("[real]\ncaptures = \"real\"\n[limits]\nphase_rms_rad = 0.05\n"));
  // its folder stands for the twin
  const RunResult recorded = capture(dir, dir / "real", {"--seed", "1", "--average", "1"});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_EQ(run_fringetwin({"capture", "--verify", (dir / "real").string()}).exit_code, 0);
  const RunResult run =
      run_fringetwin({"cosim", (dir / "twin.toml").string(), "--out", (dir / "out").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = read_json(dir / "out" / "result.json");
  EXPECT_EQ(json["verdict"].get<std::string>(), "pass");
  for (const auto& row : json["explained"])
    EXPECT_TRUE(row["explained"].get<bool>()) << row["quantity"] << " " << row["region"];
  EXPECT_NEAR(json["gain"][0]["gain_dn"].get<double>(), 20.0,
              4.0 * json["gain"][0]["gain_sigma_dn"].get<double>());
}

TEST(CaptureCommand, FramesWithoutNoiseAreWhatRenderWrites) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_render");
  ASSERT_EQ(render_twin(small_twin(), dir).exit_code, 0);
  ASSERT_EQ(capture(dir / "twin.toml", dir / "real").exit_code, 0);
  int images = 0;
  for (const auto& entry : fs::directory_iterator(dir / "out" / "left")) {
    EXPECT_EQ(read_file(entry.path()), read_file(dir / "real" / "left" / entry.path().filename()));
    ++images;
  }
  EXPECT_EQ(images, 12);
  // Without settling, a light that comes late is seen too early: the check above can fail.
  const RunResult early =
      capture(dir / "twin.toml", dir / "early", {"--settle", "0", "--simulated-latency-ms", "40"});
  ASSERT_EQ(early.exit_code, 0) << early.err;
  EXPECT_NE(read_file(dir / "out/left/0001.png"), read_file(dir / "early/left/0001.png"));
}

// A twin of 12 bit, filled by 8 bit cameras at three exposures.
TEST(CaptureCommand, BracketsWidenTheRange) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_brackets");
  const std::string dim = "intensity = 40";
  write_file(dir / "rig.toml", small_twin({{"gain_dn = 20", kNoise}, {dim, "intensity = 4"}}));
  const auto noise_mm = [&](const std::string& exposures, const std::string& out) {
    write_file(dir / "twin.toml", small_twin({{"gain_dn = 20", std::string(kNoise) + "\nbit_depth = 12"},
                                              {dim, "intensity = 4"}}));
    const RunResult run = run_fringetwin({"capture", (dir / "twin.toml").string(), "--camera",
                                          "twin:" + (dir / "rig.toml").string(), "--out",
                                          (dir / out).string(), "--exposure-ms", exposures});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const RunResult measured = run_fringetwin({"measure", (dir / "twin.toml").string(), "--captures",
                                               (dir / out).string(), "--out", (dir / "measured").string()});
    EXPECT_EQ(measured.exit_code, 0) << measured.err;
    return read_json(dir / "measured/result.json")["fits"][0]["measured"]["rms_mm"].get<double>();
  };
  const double short_only = noise_mm("10,10.5", "short"), bracketed = noise_mm("10,40,160", "wide");
  EXPECT_LT(bracketed, short_only / 3.0);
  for (const char* set : {"exposure_10_ms", "exposure_40_ms", "exposure_160_ms"})
    EXPECT_EQ(run_fringetwin({"capture", "--verify", (dir / "wide" / set).string()}).exit_code, 0) << set;
}

TEST(CaptureCommand, RepeatsFeedPhotometry) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_repeats");
  write_file(dir / "twin.toml", noisy_twin());
  const RunResult run = capture(dir / "twin.toml", dir / "real", {"--repeats", "6", "--dark", "8"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::vector<std::string> args = {"photometry", (dir / "twin.toml").string(),
                                   "--out",      (dir / "found").string(),
                                   "--dark",     (dir / "real/dark/left/*.png").string()};
  for (const char* set : {"", "repeat_01", "repeat_02", "repeat_03", "repeat_04", "repeat_05"})
    args.insert(args.end(), {"--captures", (dir / "real" / set).string()});
  const RunResult photometry = run_fringetwin(args);
  ASSERT_EQ(photometry.exit_code, 0) << photometry.err;
  const auto transfer = read_json(dir / "found/photometry.json")["cameras"][0]["photon_transfer"];
  const auto near = [&](const char* name, const char* sigma, double truth) {
    EXPECT_NEAR(transfer[name].get<double>(), truth, 4.0 * transfer[sigma].get<double>()) << name;
    EXPECT_LT(transfer[sigma].get<double>(), 0.05 * truth) << name;
  };
  near("electrons_per_dn", "electrons_per_dn_sigma", 40.0);
}

// The simulated light comes 20 ms after a pattern is shown; brightness goes with the exposure.
TEST(CaptureCommand, LatencyAndExposureAreFoundAndUsed) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_prepare");
  write_file(dir / "twin.toml", noisy_twin());
  const RunResult run =
      capture(dir / "twin.toml", dir / "real", {"--auto-exposure", "--calibrate-latency", "--references"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("use --latency-ms"));
  const std::string toml = read_file(dir / "real/capture.toml");
  double latency_ms = 0.0;
  ASSERT_EQ(std::sscanf(toml.substr(toml.find("\"latency_ms\" = ")).c_str(), "\"latency_ms\" = \"%lf\"",
                        &latency_ms),
            1);
  EXPECT_GE(latency_ms, 20.0);
  EXPECT_LT(latency_ms, 20.0 + 1000.0 / 60.0 + 1.5);  // at most the frame it is noticed in, and the margin
  // white is as bright as it can be: at most 0.1 % saturated, the next thousandth within 3 % of full scale
  ImageF white = read_gray(dir / "real/left/white.png").image;
  std::sort(white.data.begin(), white.data.end());
  const std::size_t n = white.size();
  EXPECT_LT(white.data[n - n / 500], 255.0f);
  EXPECT_GT(white.data[n - n / 500], 247.0f);

  const RunResult preview =
      run_fringetwin({"capture", (dir / "twin.toml").string(), "--camera",
                      "twin:" + (dir / "twin.toml").string(), "--preview", "--preview-looks", "2"});
  EXPECT_EQ(preview.exit_code, 0) << preview.err;
  EXPECT_EQ(std::count(preview.out.begin(), preview.out.end(), '\n'), 2);
  EXPECT_THAT(preview.out, HasSubstr("left: saturated 0.00 %"));
  expect_refused(capture(dir / "twin.toml", dir / "q", {"--auto-exposure", "--exposure-ms", "3"}), 2,
                 {"exclude each other"});
}

// Every third moment between two changes of the folder (capture_full_test.cpp: each).
TEST(CaptureCommand, KilledBetweenAnyTwoChangesItIsWholeOrResumes) {
  FT_NEED_DEVICE();
  EXPECT_GT(kill_between_changes(3), 13);
}

TEST(CaptureCommand, OnlyTheSameRecordingIsResumed) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_resume");
  write_file(dir / "twin.toml", small_twin());
  write_file(dir / "other.toml", small_twin({{"intensity = 40", "intensity = 20"}}));
  const auto args = [&](const char* rig, std::vector<std::string> more) {
    more.insert(more.begin(), {"capture", (dir / "twin.toml").string(), "--camera",
                               "twin:" + (dir / rig).string(), "--out", (dir / "real").string()});
    return more;
  };
  EXPECT_NE(die_at(12, dir / "real", args("twin.toml", {})).exit_code, 0);
  expect_refused(run_fringetwin(args("other.toml", {"--resume"})), 2, {"was begun with"});
  expect_refused(run_fringetwin(args("twin.toml", {"--resume", "--seed", "7"})), 2,
                 {"begun with seed = 0, now it is 7"});
  expect_refused(run_fringetwin(args("twin.toml", {})), 2, {"unfinished recording"});
  EXPECT_EQ(run_fringetwin(args("twin.toml", {"--resume"})).exit_code, 0);
  EXPECT_EQ(run_fringetwin(args("twin.toml", {"--resume"})).exit_code, 0);
  write_file(dir / "real/left/0003.png", "garbage");
  expect_refused(run_fringetwin(args("twin.toml", {"--resume"})), 3, {"0003.png", "--overwrite"});
}

// Gray values of dark and flat frames are those of the black and white images of the same exposure.
TEST(CaptureCommand, DarkAndFlatHaveTheExposureOfTheImages) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_dark");
  write_file(dir / "twin.toml", small_twin({{"gain_dn = 20", "gain_dn = 20\nexposure_ms = 10"}}));
  const RunResult run = capture(dir / "twin.toml", dir / "real",
                                {"--exposure-ms", "4", "--dark", "1", "--flat", "1", "--references"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const auto& [frame, image] :
       {std::pair{"dark/left/0000.png", "left/black.png"}, {"flat/left/0000.png", "left/white.png"}})
    EXPECT_EQ(read_file(dir / "real" / frame), read_file(dir / "real" / image)) << frame;
}

/// Kills the recording after a random time; true when it came to its end before.
bool record_until_killed(const fs::path& dir, double seconds) {
  const std::string command = fmt::format(
      "timeout -s KILL {:.3f} '{}' -q capture '{}' --camera 'twin:{}' --out '{}' --exposure-ms 5,10,20 "
      "--resume 2>&1",
      seconds, std::getenv("FRINGETWIN_BINARY"), (dir / "twin.toml").string(), (dir / "twin.toml").string(),
      (dir / "set").string());
  return testing::run(command).status == 0;
}

TEST(CaptureCommand, KilledFiftyTimesNothingIsLost) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_kills");
  write_file(dir / "twin.toml", noisy_twin());
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(record_until_killed(dir, 60.0));
  const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fs::rename(dir / "set", dir / "unbroken");
  std::mt19937 random(6);
  std::uniform_real_distribution<double> moment(0.3 * whole_s, 1.05 * whole_s);
  int kills = 0, with_images = 0, complete = 0;
  bool ended = false;
  for (int attempt = 0; attempt < 200 && (kills < 50 || !ended); ++attempt) {
    ended = record_until_killed(dir, kills < 50 ? moment(random) : 60.0);  // at last undisturbed
    if (!ended) ++kills;
    if (!fs::exists(dir / "set")) continue;
    // Between the two moments the set is whole, but says that it is not: --resume settles it.
    const bool has_toml =
        fs::exists(dir / "set/capture.toml") && !fs::exists(dir / "set" / capture::kJournalName);
    const capture::SetCheck check = capture::verify_set(dir / "set");
    ASSERT_EQ(check.passed(), has_toml) << ::testing::PrintToString(check.findings);
    with_images += fs::exists(dir / "set/exposure_5_ms") ? 1 : 0;
    if (!has_toml) continue;
    // complete: the same as without a kill
    for (const char* set : {"", "exposure_5_ms", "exposure_20_ms"})
      for (int i = 0; i < 12; ++i) {
        const std::string file = fmt::format("left/{:04d}.png", i);
        ASSERT_EQ(read_file(dir / "set" / set / file), read_file(dir / "unbroken" / set / file))
            << set << file;
      }
    fs::remove_all(dir / "set");
    ++complete;
  }
  EXPECT_EQ(kills, 50);
  EXPECT_GT(with_images, 10) << "the kills came before there was anything to lose";
  EXPECT_GT(complete, 0);
  std::printf("killed %d times, %d of them with images; %d sets completed\n", kills, with_images, complete);
}

TEST(CaptureCommand, BadInput) {
  FT_NEED_DEVICE();
  const fs::path dir = scratch_folder("capture_bad");
  const fs::path twin = dir / "twin.toml", out = dir / "out";
  write_file(twin, small_twin());
  const auto run = [&](std::vector<std::string> args) {
    args.insert(args.begin(), {"capture", twin.string(), "--out", out.string()});
    return run_fringetwin(args);
  };
  const std::string rehearsal = "twin:" + twin.string();
  expect_refused(run({}), 2, {"no camera given", "--camera left=/dev/video0"});
  expect_refused(run({"--camera", "/dev/video99", "--display", "kms"}), 4,
                 {"/dev/video99", "cannot be opened"});
  expect_refused(run({"--camera", "rear=/dev/video0", "--display", "kms"}), 2, {"no camera \"rear\""});
  expect_refused(run({"--camera", "/dev/video0"}), 2, {"no display given"});
  expect_refused(run({"--camera", rehearsal, "--display", "kms"}), 2, {"exclude each other"});
  expect_refused(run({"--camera", rehearsal, "--exposure-ms", "5,5"}), 2, {"names one exposure twice"});
  expect_refused(run({"--camera", rehearsal, "--average", "0"}), 2, {"--average", "must be 1 to"});
  expect_refused(run({"--camera", rehearsal, "--exposure-ms", "5,9", "--repeats", "2"}), 2,
                 {"--repeats", "exclude each other"});
  expect_refused(run({"--camera", rehearsal, "--exposure-ms", "5000"}), 4, {"takes exposures of"});
  expect_refused(run({"--camera", rehearsal, "--resume", "--overwrite"}), 2, {"exclude each other"});
  expect_refused(run({"--camera", "twin:" + (dir / "none.toml").string()}), 2, {"none.toml"});
  fs::create_directories(dir / "empty");
  expect_refused(run({"--camera", "twin:" + (dir / "empty").string()}), 2,
                 {"empty: is a folder without a twin.toml"});
  expect_refused(run_fringetwin({"cosim", (dir / "empty").string(), "--out", out.string()}), 2,
                 {"empty: is a folder without a twin.toml"});
  EXPECT_FALSE(fs::exists(out / "capture.toml"));
  write_file(dir / "other.toml", small_twin({{"imagersize = [160, 120]", "imagersize = [150, 120]"}}));
  expect_refused(run({"--camera", "twin:" + (dir / "other.toml").string()}), 4,
                 {"delivers 150 x 120 px", "has 160 x 120"});
  expect_refused(run_fringetwin({"capture", "--verify", (dir / "nowhere").string()}), 3, {"no such folder"});
}

}  // namespace
}  // namespace fringetwin::testing::capture_test
