// SPDX-License-Identifier: Apache-2.0
// `fringetwin capture --camera genicam:` as a user runs it. A GigE Vision camera in software sees the screen
// of a virtual X server pixel for pixel, so that every image recorded has one right content: the pattern
// shown. Packets are lost, the camera dies, another program holds it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "capture/device/pattern.hpp"
#include "capture/genicam/genicam_list.hpp"
#include "tests/support/capture/fake_gige.hpp"
#include "tests/support/capture/xvfb.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::genicam_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = 160, kHeight = 120;

/// Names the places of a pixel's low bits, which no pattern has: unpacking errors show.
unsigned low_bits(int x, int y, int bits) { return static_cast<unsigned>(x + 3 * y) & ((1u << bits) - 1u); }

class Rig {
 public:
  explicit Rig(const std::string& name, int bits) : bits_(bits), dir_(scratch_folder("genicam_" + name)) {
    write_file(dir_ / "twin.toml",
               small_twin({{"imagersize = [1280, 720]", "imagersize = [160, 120]"},
                           {"gain_dn = 20", "gain_dn = 20\nbit_depth = " + std::to_string(bits)}}));
    twin_ = load_twin(dir_ / "twin.toml");
    fake.set_period_us(10'000);
    fake.show([this](const GigeFrame& frame) { return seen(frame); });
  }

  const fs::path& dir() const { return dir_; }
  bool has_display() const { return server_.started(); }
  RunResult capture(const std::vector<std::string>& more) const {
    std::vector<std::string> args = {"capture",   (dir_ / "twin.toml").string(),
                                     "--camera",  "left=genicam:T01",
                                     "--control", "left:OffsetX=0",
                                     "--display", "window",
                                     "--out",     (dir_ / "real").string()};
    args.insert(args.end(), more.begin(), more.end());
    return run_fringetwin(args);
  }

  /// Kills a recording, or its resumption, after some seconds; true when it came to its end before.
  bool record_until_killed(double seconds) const {
    return testing::run(
               fmt::format("timeout -s KILL {:.3f} '{}' -q capture '{}' --camera left=genicam:T01 --control "
                           "left:OffsetX=0 --display window --latency-ms 30 --out '{}' --resume 2>&1",
                           seconds, std::getenv("FRINGETWIN_BINARY"), (dir_ / "twin.toml").string(),
                           (dir_ / "real").string()))
               .status == 0;
  }

  int n_patterns() const { return static_cast<int>(sequence_patterns(twin_.fringes).size()); }
  /// Returns how many of the recorded images are there and how many are not the pattern they stand for.
  std::pair<int, int> recorded_and_wrong() const {
    int recorded = 0, wrong = 0;
    const std::vector<Pattern> patterns = sequence_patterns(twin_.fringes);
    for (std::size_t k = 0; k < patterns.size(); ++k) {
      const fs::path file = dir_ / "real/left" / fmt::format("{:04}.png", k);
      if (!fs::exists(file)) continue;
      ++recorded;
      wrong += read_gray(file).image.data != expected(patterns[k]).data;
    }
    return {recorded, wrong};
  }

  FakeGige fake;

 private:
  std::uint16_t value(unsigned level, int x, int y) const {
    const int extra = bits_ - 8;
    return static_cast<std::uint16_t>(level << extra | low_bits(x, y, extra));
  }
  /// What a camera of one pixel per pixel sees of the screen.
  ImageU16 seen(const GigeFrame& frame) const {
    ImageU16 dn(frame.width, frame.height);
    const Image<std::uint32_t> screen = server_.screen(0);
    for (int y = 0; y < std::min(dn.height, screen.height); ++y)
      for (int x = 0; x < std::min(dn.width, screen.width); ++x) dn(x, y) = value(screen(x, y) & 0xff, x, y);
    return dn;
  }
  ImageF expected(const Pattern& pattern) const {
    const ImageU16 levels = quantise_levels(pattern_levels(twin_.fringes, pattern, kWidth, kHeight), 8);
    ImageF image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) image(x, y) = value(levels(x, y), x, y);
    return image;
  }

  int bits_;
  Xvfb server_{{{kWidth, kHeight}}};
  fs::path dir_;
  Twin twin_;
};

TEST(GenicamCapture, EveryImageIsThePatternShown) {
  for (const auto& [format, bits] : {std::pair{"Mono8", 8},
                                     {"Mono12", 12},
                                     {"Mono12p", 12},
                                     {"Mono12Packed", 12},
                                     {"Mono10p", 10},
                                     {"Mono16", 16}}) {
    Rig rig(format, bits);
    FT_NEED_XVFB(rig.has_display());
    const RunResult run = rig.capture({"--format", format, "--latency-ms", "30"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(rig.recorded_and_wrong(), std::pair(rig.n_patterns(), 0)) << format;
    EXPECT_EQ(run_fringetwin({"capture", "--verify", (rig.dir() / "real").string()}).exit_code, 0);
    const std::string toml = read_file(rig.dir() / "real/capture.toml");
    for (const char* part :
         {"\"serial left\" = \"T01\"", "\"control.GainAuto left\" = \"Off\"",
          "\"control.ExposureTimeAbs left\"", "\"control.OffsetX left\" = \"0\"", "\"settle frames\" = \"0\"",
          "\"frames lost\" = ", "\"trigger left\" = \"software", "\"underruns left\" = "})
      EXPECT_THAT(toml, HasSubstr(part));
  }
}

TEST(GenicamCapture, FramesThatComeByThemselvesAreSettled) {
  Rig rig("free", 8);
  FT_NEED_XVFB(rig.has_display());
  const RunResult run = rig.capture({"--trigger", "off", "--settle", "3", "--exposure-unit-ms", "7"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr(fmt::format("{0} patterns, {0} frames of each camera: ", rig.n_patterns())));
  EXPECT_THAT(run.err, HasSubstr("frames of the projector (7 ms)"));
  EXPECT_EQ(rig.recorded_and_wrong(), std::pair(rig.n_patterns(), 0));
}

// 19,200 bytes are 15 packets: with 2 % lost three frames of four are whole, with 5 % less than half.
TEST(GenicamCapture, LostPacketsCostTimeAndNoImage) {
  for (const double share : {0.005, 0.02, 0.05}) {
    Rig rig("lossy", 8);
    FT_NEED_XVFB(rig.has_display());
    rig.fake.lose(share);
    RunResult run = rig.capture({"--latency-ms", "30", "--timeout-ms", "700"});
    for (int tries = 0; run.exit_code == 4 && tries < 5; ++tries) {
      EXPECT_THAT(run.err, HasSubstr("--resume"));
      EXPECT_EQ(rig.recorded_and_wrong().second, 0);
      run = rig.capture({"--latency-ms", "30", "--timeout-ms", "700", "--resume"});
    }
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(rig.recorded_and_wrong(), std::pair(rig.n_patterns(), 0)) << share;
    // 180 packets at least: that none is lost of them has probability 0.95^180 = 1e-4
    if (share == 0.05) {
      EXPECT_THAT(read_file(rig.dir() / "real/frames.csv"), HasSubstr("missing packets"));
    }
  }
}

TEST(GenicamCapture, ACameraThatDiesLeavesARecordingToGoOnWith) {
  Rig rig("dies", 12);
  FT_NEED_XVFB(rig.has_display());
  rig.fake.set_period_us(100'000);
  std::thread death([&] {
    while (rig.fake.n_sent() < 6) std::this_thread::sleep_for(5ms);
    rig.fake.kill();
  });
  const RunResult broken = rig.capture({"--latency-ms", "30", "--timeout-ms", "500"});
  death.join();
  EXPECT_EQ(broken.exit_code, 4) << broken.out;
  EXPECT_THAT(broken.err, HasSubstr("go on with --resume"));
  EXPECT_FALSE(fs::exists(rig.dir() / "real/capture.toml"));
  const auto [recorded, wrong] = rig.recorded_and_wrong();
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(recorded, 0);
  EXPECT_LT(recorded, rig.n_patterns());
  rig.fake.revive();
  rig.fake.set_period_us(10'000);
  const RunResult resumed = rig.capture({"--latency-ms", "30", "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(rig.recorded_and_wrong(), std::pair(rig.n_patterns(), 0));
}

// The camera is switched off and on after each kill, or it is held for three seconds more.
TEST(GenicamCapture, KilledFiftyTimesNoImageIsWrong) {
  Rig rig("kills", 12);
  FT_NEED_XVFB(rig.has_display());
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(rig.capture({"--latency-ms", "30"}).exit_code, 0);
  const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const fs::path set = rig.dir() / "real";
  fs::remove_all(set);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> moment(0.4 * whole_s, 1.02 * whole_s);
  int kills = 0, with_images = 0, complete = 0;
  bool ended = false;
  for (int attempt = 0; attempt < 200 && (kills < 50 || !ended); ++attempt) {
    ended = rig.record_until_killed(kills < 50 ? moment(random) : 60.0);  // at last undisturbed
    if (!ended) ++kills;
    rig.fake.kill();
    rig.fake.revive();
    const auto [recorded, wrong] = rig.recorded_and_wrong();
    ASSERT_EQ(wrong, 0);
    with_images += recorded > 0 ? 1 : 0;
    if (!fs::exists(set / "capture.toml") || fs::exists(set / "capture.journal")) continue;
    ASSERT_EQ(recorded, rig.n_patterns());
    ASSERT_EQ(run_fringetwin({"capture", "--verify", set.string()}).exit_code, 0);
    fs::remove_all(set);
    ++complete;
  }
  EXPECT_EQ(kills, 50);
  EXPECT_GT(with_images, 10) << "the kills came before there was anything to lose";
  EXPECT_GT(complete, 0);
  std::printf("killed %d times, %d of them with images; %d sets completed\n", kills, with_images, complete);
}

TEST(GenicamCapture, ACameraOfAnotherProgramIsNotTaken) {
  Rig rig("held", 8);
  FT_NEED_XVFB(rig.has_display());
  std::map<std::string, std::string> ignored;
  {
    const auto holder = open_genicam("genicam:T01", &ignored);
    const RunResult run = rig.capture({});
    EXPECT_EQ(run.exit_code, 4);
    EXPECT_THAT(run.err, HasSubstr("held by another program"));
    EXPECT_FALSE(fs::exists(rig.dir() / "real"));
    EXPECT_THAT(run_fringetwin({"capture", "--list"}).out, HasSubstr("held by another program"));
  }
  EXPECT_EQ(rig.capture({"--latency-ms", "30"}).exit_code, 0);
}

TEST(GenicamCapture, MistakesAreOneSentence) {
  Rig rig("mistakes", 8);
  FT_NEED_XVFB(rig.has_display());
  EXPECT_THAT(rig.capture({"--control", "Gain=0"}).err, HasSubstr("it has GainRaw, GainAuto"));
  EXPECT_THAT(rig.capture({"--control", "GainRaw=1000000"}).err, HasSubstr("out of range"));
  EXPECT_THAT(rig.capture({"--format", "Mono13"}).err, HasSubstr("it has BayerBG8"));
  EXPECT_FALSE(fs::exists(rig.dir() / "real"));
  const RunResult list = run_fringetwin({"capture", "--list"});
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.out, HasSubstr("genicam:T01: Aravis Fake (GigEVision, 127.0.0.1)"));
}

}  // namespace
}  // namespace fringetwin::testing::genicam_test
