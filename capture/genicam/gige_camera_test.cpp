// SPDX-License-Identifier: Apache-2.0
// The GenICam camera on real packets: Aravis' GigE Vision camera in software sends pictures of known noise
// over the loopback, every pixel is compared, packets are lost, the camera dies, another program holds it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "capture/genicam/genicam_camera.hpp"
#include "capture/genicam/genicam_list.hpp"
#include "tests/support/capture/fake_gige.hpp"

namespace fringetwin::testing::gige_camera_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::HasSubstr;

using Pixels = CameraDevice::Pixels;

struct Bench {
  FakeGige fake;
  GenicamCameraOptions options;
  std::map<std::string, std::string> provenance;
  bool known = false;  ///< to Aravis
  Bench() {
    options.name = "genicam:T01";
    options.width = 100;
    options.height = 38;
    options.controls = {{"OffsetX", "0"}};  // a region of the sensor's 2048 x 2048
  }
  std::unique_ptr<GenicamCamera> camera() {
    std::string fault;  // without looking for it, which takes a second
    auto device = options.name == "genicam:T01" && known ? genicam_module().open("Aravis-Fake-T01", &fault)
                                                         : open_genicam(options.name, &provenance);
    known = true;
    return std::make_unique<GenicamCamera>(options, std::move(device), provenance);
  }
  std::unique_ptr<GenicamCamera> started() {
    auto made = camera();
    made->start();
    return made;
  }
  std::string refusal() {
    try {
      camera();
    } catch (const UserError& error) {
      return error.what();
    }
    return "none";
  }
  /// The picture that was sent, by the 16-bit id of a frame's number.
  ImageU16 sent(const Frame& frame) const { return fake.sent((frame.sequence - 1) % 65535 + 1); }
};

struct Tally {
  int good = 0, wrong = 0, faulty = 0, lost = 0, timeouts = 0;
};

Tally take(Bench& bench, GenicamCamera& camera, int n) {
  Tally tally;
  FrameOrder order;
  for (int i = 0; i < n; ++i) {
    try {
      const Frame frame = camera.next_frame(300ms, Pixels::keep);
      const std::uint32_t ahead = order.advance(frame);
      tally.lost += static_cast<int>(ahead) - 1;
      if (frame.fault != FrameFault::none)
        ++tally.faulty;
      else
        ++(frame.dn.data == bench.sent(frame).data && !frame.dn.empty() ? tally.good : tally.wrong);
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(fault.kind(), DeviceFault::Kind::timeout) << fault.what();
      ++tally.timeouts;
      camera.start();
      order = FrameOrder();
    }
  }
  return tally;
}

TEST(GigeCamera, EveryFormatArrivesBitForBit) {
  Bench bench;
  ASSERT_TRUE(bench.fake.running());
  for (const char* format :
       {"Mono8", "Mono10", "Mono10p", "Mono10Packed", "Mono12", "Mono12p", "Mono12Packed", "Mono14", "Mono16",
        "BayerRG8", "BayerGR10", "BayerGB12p", "BayerBG12Packed", "BayerRG16", "BayerGB10p"}) {
    bench.options.format = format;
    const auto camera = bench.started();
    const Tally tally = take(bench, *camera, 8);
    EXPECT_EQ(tally.good, 8) << format;
    EXPECT_EQ(tally.wrong + tally.faulty + tally.lost + tally.timeouts, 0) << format;
    EXPECT_EQ(camera->info().bit_depth, pfnc_format_of_name(format)->bit_depth);
  }
}

// Aravis' camera begins shortly before 65535.
// Two cameras, each asked for a frame of every pattern, at once.
TEST(GigeCamera, TwoAtOnceTakeAThousandPatternsBitForBit) {
  const std::string other = other_interface_address();
  if (other.empty()) GTEST_SKIP() << "SKIPPED: no network interface for a second camera";
  FakeGige left_fake("T01", "127.0.0.1"), right_fake("T02", other);
  for (FakeGige* fake : {&left_fake, &right_fake}) fake->set_period_us(500);
  for (const char* format : {"Mono8", "Mono12", "Mono12p", "Mono16"}) {
    std::vector<std::unique_ptr<GenicamCamera>> cameras;
    for (const std::string& name : {std::string("genicam:T01"), "genicam:" + other}) {
      GenicamCameraOptions options;
      options.name = name;
      options.format = format;
      options.width = 100;
      options.height = 38;
      options.controls = {{"OffsetX", "0"}};
      std::map<std::string, std::string> provenance;
      auto device = open_genicam(name, &provenance);
      cameras.push_back(std::make_unique<GenicamCamera>(options, std::move(device), provenance));
      EXPECT_EQ(cameras.back()->info().provenance.at("serial"), cameras.size() == 1 ? "T01" : "T02");
      cameras.back()->start();
    }
    std::array<int, 2> good{}, bad{};
    std::array<FrameOrder, 2> orders;
    for (int pattern = 0; pattern < 1000; ++pattern) {
      for (const auto& camera : cameras) camera->trigger();
      for (std::size_t c = 0; c < 2; ++c) {
        const Frame frame = cameras[c]->next_frame(2000ms, Pixels::keep);
        const FakeGige& fake = c == 0 ? left_fake : right_fake;
        const bool right = frame.fault == FrameFault::none && orders[c].advance(frame) == 1 &&
                           frame.dn.data == fake.sent((frame.sequence - 1) % 65535 + 1).data;
        ++(right ? good : bad)[c];
      }
    }
    EXPECT_EQ(good, (std::array{1000, 1000})) << format;
    EXPECT_EQ(bad, (std::array{0, 0})) << format;
  }
}

TEST(GigeCamera, TheCountGoesOnWhereBlockIdsBeginAnew) {
  Bench bench;
  bench.options.trigger = GenicamTrigger::off;
  const auto camera = bench.started();
  std::uint32_t highest = 0;
  FrameOrder order;
  for (int i = 0; i < 400; ++i) {
    const Frame frame = camera->next_frame(500ms, Pixels::keep);
    ASSERT_EQ(frame.fault, FrameFault::none);
    ASSERT_GE(order.advance(frame), 1u);
    ASSERT_EQ(frame.dn.data, bench.sent(frame).data) << frame.sequence;
    highest = std::max(highest, frame.sequence);
  }
  EXPECT_GT(highest, 65535u);
}

TEST(GigeCamera, LostPacketsLeaveNoWrongImage) {
  for (const double share : {0.005, 0.02, 0.05}) {
    Bench bench;
    bench.options.width = 256;
    bench.options.height = 64;  // a dozen packets
    const auto camera = bench.started();
    bench.fake.lose(share);
    const Tally tally = take(bench, *camera, 80);
    EXPECT_EQ(tally.wrong, 0) << share;
    EXPECT_GT(tally.good, 10) << share;
    // 80 frames of 14 packets: none lost has probability 0.995^1120 = 0.4 % at the least share
    EXPECT_GT(tally.faulty + tally.timeouts, 0) << share;
    camera->stop();
    const auto provenance = camera->info().provenance;
    EXPECT_NE(provenance.at("packets_missing"), "0") << share;
  }
}

TEST(GigeCamera, ADeadCameraIsGone) {
  Bench bench;
  const auto camera = bench.started();
  EXPECT_EQ(take(bench, *camera, 2).good, 2);
  bench.fake.kill();
  try {
    camera->next_frame(500ms, Pixels::keep);
    FAIL() << "a frame of a dead camera";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), DeviceFault::Kind::gone);
    EXPECT_THAT(fault.what(), HasSubstr("genicam:T01"));
  }
  EXPECT_NO_THROW(camera->stop());
  bench.fake.revive();
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(take(bench, *bench.started(), 2).good, 2);
}

TEST(GigeCamera, AnotherProgramsCameraIsRefused) {
  Bench bench;
  std::map<std::string, std::string> other;
  const auto holder = open_genicam("genicam:T01", &other);
  ASSERT_TRUE(holder->controlled());
  bench.known = true;
  EXPECT_THAT(bench.refusal(), HasSubstr("is held by another program"));
}

TEST(GigeCamera, APulseOnTheLineIsAFrame) {
  Bench bench;
  bench.options.trigger = GenicamTrigger::line;
  bench.options.trigger_line = "line0";
  const auto camera = bench.started();
  const CameraInfo info = camera->info();
  EXPECT_EQ(info.pulse_line, "Line0");
  EXPECT_FALSE(info.triggered);
  EXPECT_EQ(info.provenance.at("control.TriggerMode"), "On");
  EXPECT_EQ(info.provenance.at("control.TriggerSource"), "Line0");
  EXPECT_EQ(info.provenance.at("trigger"), "Line0, a pulse for each frame");
  const auto no_frame = [&] {
    try {
      camera->next_frame(20ms, Pixels::keep);
      ADD_FAILURE() << "a frame without a pulse";
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(fault.kind(), DeviceFault::Kind::timeout) << fault.what();
    }
  };
  no_frame();
  std::optional<std::uint32_t> last;
  for (int i = 0; i < 10; ++i) {
    const TimeNs stamp_ns = 1'000'000'000 + i * 20'000'000;
    ASSERT_TRUE(bench.fake.pulse(stamp_ns));
    const Frame frame = camera->next_frame(1s, Pixels::keep);
    EXPECT_EQ(frame.camera_ns, stamp_ns);
    EXPECT_EQ(frame.fault, FrameFault::none);
    EXPECT_EQ(frame.dn.data, bench.sent(frame).data);
    if (last) {
      EXPECT_EQ(frame.sequence, *last + 1);  // looking in vain began no new stream
    }
    last = frame.sequence;
    no_frame();
  }
  camera->stop();
  EXPECT_FALSE(bench.fake.pulse(1));
}

TEST(GigeCamera, ALineThatItLacksIsAnsweredWithThoseItHas) {
  Bench bench;
  bench.options.trigger = GenicamTrigger::line;
  for (const char* line : {"Line7", "Lin0", "Software"}) {
    bench.options.trigger_line = line;
    EXPECT_THAT(bench.refusal(), HasSubstr("has no trigger line '" + std::string(line) + "'; it has Line0"));
  }
  bench.options.trigger_line = "Line0";
  bench.options.rate_hz = 10.0;
  EXPECT_THAT(bench.refusal(), HasSubstr("takes a frame for each pulse, so that no rate can be set"));
}

TEST(GigeCamera, SettingsAreReadBackAndRecorded) {
  Bench bench;
  bench.options.controls.push_back({"gainraw", "7"});
  bench.options.stored_bits = 12;
  const auto camera = bench.camera();
  EXPECT_NEAR(camera->set_exposure_ms(2.5), 2.5, 1e-9);
  EXPECT_NEAR(*camera->exposure_ms(), 2.5, 1e-9);
  const CameraInfo info = camera->info();
  EXPECT_TRUE(info.triggered);
  EXPECT_EQ(info.bit_depth, 12);
  const auto& got = info.provenance;
  EXPECT_EQ(got.at("control.GainRaw"), "7");
  EXPECT_EQ(got.at("control.GainAuto"), "Off");
  EXPECT_EQ(got.at("control.PixelFormat"), "Mono12p");
  EXPECT_EQ(got.at("control.Width"), "100");
  EXPECT_EQ(got.at("control.BinningHorizontal"), "1");
  EXPECT_EQ(got.at("serial"), "T01");
  EXPECT_EQ(got.at("protocol"), "GigEVision");
}

TEST(GigeCamera, WhatItCannotDoIsRefusedWithWhatItCan) {
  Bench bench;
  const GenicamCameraOptions plain = bench.options;
  const auto refusal_with = [&](const std::string& name, const std::string& value) {
    bench.options = plain;
    bench.options.controls.emplace_back(name, value);
    return bench.refusal();
  };
  EXPECT_THAT(refusal_with("GainRaw", "1.5"), HasSubstr("whole number"));
  EXPECT_THAT(refusal_with("GainAuto", "Sometimes"), HasSubstr("Off, Once, Continuous"));
  EXPECT_THAT(refusal_with("Gain", "1"), HasSubstr("GainRaw"));
  EXPECT_THAT(refusal_with("Width", "100"), HasSubstr("imagersize"));
  bench.options = plain;
  bench.options.format = "RGB8";
  EXPECT_THAT(bench.refusal(), HasSubstr("none of the formats that are understood"));
  bench.options = plain;
  bench.options.controls.clear();
  EXPECT_THAT(bench.refusal(), HasSubstr("2048 x 2048"));
  bench.options = plain;
  bench.options.name = "genicam:nobody";
  EXPECT_THAT(bench.refusal(), HasSubstr("genicam:T01"));
  bench.options.name = "genicam:";  // the only one
  EXPECT_EQ(bench.refusal(), "none");
}

TEST(GigeCamera, ListedWithFormatsAndRanges) {
  Bench bench;
  EXPECT_THAT(list_genicam_cameras(),
              Contains(::testing::AllOf(HasSubstr("genicam:T01: Aravis Fake (GigEVision, 127.0.0.1)"),
                                        HasSubstr("Mono12p"), HasSubstr("not supported: RGB8"),
                                        HasSubstr("ExposureTimeAbs"), HasSubstr("TriggerSource"))));
}

}  // namespace
}  // namespace fringetwin::testing::gige_camera_test
