// SPDX-License-Identifier: Apache-2.0
// The GenICam camera on a module in software: whatever fails, at the module, at opening, in a setting or at a
// frame, is told by what it is. Real packets: gige_camera_test.cpp.
#include "capture/genicam/genicam_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/genicam/genicam_list.hpp"
#include "tests/support/capture/fake_genicam.hpp"
#include "tests/support/twin/expect_user_error.hpp"

namespace fringetwin::testing::genicam_camera_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

using Pixels = CameraDevice::Pixels;
using Provenance = std::map<std::string, std::string>;

struct Bench {
  FakeGenicamModule module;
  FakeGenicamState& state = module.state;
  GenicamCameraOptions options;
  Bench() {
    options.name = "genicam:S1";
    options.width = 4;
    options.height = 2;
  }
  std::unique_ptr<GenicamCamera> camera() {
    Provenance provenance;
    auto device = open_genicam(options.name, &provenance, module);
    return std::make_unique<GenicamCamera>(options, std::move(device), provenance);
  }
  std::unique_ptr<GenicamCamera> started() {
    auto made = camera();
    made->start();
    return made;
  }
  void expect_refused(const std::string& words) {
    expect_user_error(ExitCode::device, words, [this] { camera(); });
  }
};

void expect_fault(DeviceFault::Kind kind, const std::string& words, const std::function<void()>& call) {
  try {
    call();
    ADD_FAILURE() << "no fault: " << words;
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), kind);
    EXPECT_THAT(fault.what(), HasSubstr("genicam:S1: "));
    EXPECT_THAT(fault.what(), HasSubstr(words));
  }
}

TEST(GenicamCamera, IsFoundBySerialAddressOrId) {
  Bench bench;
  for (const char* name : {"genicam:S1", "genicam:192.168.0.7", "genicam:Fake-1"})
    EXPECT_EQ(find_genicam(bench.module.list, name).id, "Fake-1") << name;
  EXPECT_EQ(find_genicam(bench.module.list, "genicam:Fake-2").id, "Fake-2");
  Provenance told;
  open_genicam("genicam:S1", &told, bench.module);
  EXPECT_EQ(told.at("driver"), "Fake 1.0");
  EXPECT_EQ(told.at("model"), "One");
}

// Behind a router, say: it answers at its address, and is not found by looking around.
TEST(GenicamCamera, IsReachedByAnAddressThatIsNotListed) {
  Bench bench;
  bench.state.features["DeviceModelName"] = FakeGenicamState::feature(FakeGenicamState::Kind::text, "Far");
  Provenance told;
  EXPECT_TRUE(open_genicam("genicam:10.1.2.3", &told, bench.module));
  EXPECT_EQ(told.at("address"), "10.1.2.3");
  EXPECT_EQ(told.at("model"), "Far");
  bench.module.fault = "Device not found";
  bench.options.name = "genicam:10.1.2.3";
  bench.expect_refused("does not answer at this address: Device not found");
}

TEST(GenicamCamera, AModuleThatFindsOrOpensNoneSaysSo) {
  Bench bench;
  bench.options.name = "genicam:";
  bench.expect_refused("means more than one camera; there are genicam:S1, genicam:Fake-2");
  bench.options.name = "genicam:S9";
  bench.expect_refused("no such GenICam camera is found; there are genicam:S1, genicam:Fake-2");
  bench.options.name = "genicam:S1";
  bench.module.fault = "Device not found";
  bench.expect_refused("genicam:S1: cannot be opened: Device not found");
  EXPECT_EQ(describe(bench.module, bench.module.list[0]),
            "genicam:S1: Fake One (GigEVision, 192.168.0.7)\n  cannot be used: Device not found\n");
  bench.module.list.clear();
  bench.expect_refused("no GenICam camera is found; look at its power and cable");
}

// They are of the kind of trigger that is selected, and some can be written only beside a line.
TEST(GenicamCamera, WhatIsSetOfTheTriggerIsSetOnceItsKindAndLineAreChosen) {
  Bench bench;
  bench.state.features["TriggerSelector"] =
      FakeGenicamState::choice("AcquisitionStart", {"AcquisitionStart", "FrameStart"});
  bench.state.features["TriggerActivation"] =
      FakeGenicamState::choice("RisingEdge", {"RisingEdge", "FallingEdge"});
  bench.options.trigger = GenicamTrigger::line;
  bench.options.trigger_line = "Line0";
  bench.options.controls = {{"TriggerActivation", "FallingEdge"}};
  bench.camera();
  std::vector<std::string> last(bench.state.written.end() - 4, bench.state.written.end());
  EXPECT_THAT(last,
              ::testing::ElementsAre("TriggerSelector", "TriggerSource", "TriggerActivation", "TriggerMode"));
  EXPECT_EQ(bench.state.features["TriggerSelector"].value, "FrameStart");
  EXPECT_EQ(bench.state.features["TriggerActivation"].value, "FallingEdge");
}

TEST(GenicamCamera, AClockOfTheNetworkIsSharedOnceItIsSettled) {
  Bench bench;
  EXPECT_FALSE(bench.started()->info().has_shared_clock);
  bench.state.features["PtpEnable"] = FakeGenicamState::feature(FakeGenicamState::Kind::boolean, "true");
  bench.state.features["PtpStatus"] = FakeGenicamState::choice("Slave", {"Listening", "Slave", "Master"});
  EXPECT_TRUE(bench.started()->info().has_shared_clock);
  EXPECT_EQ(bench.started()->info().provenance.at("ptp"), "Slave");
  bench.state.features["PtpStatus"].value = "Listening";
  bench.options.ptp_wait = 10ms;
  EXPECT_FALSE(bench.started()->info().has_shared_clock);
  bench.state.features["PtpEnable"].value = "false";
  EXPECT_FALSE(bench.started()->info().provenance.contains("ptp"));
}

TEST(GenicamCamera, OneThatIsHeldIsRefused) {
  Bench bench;
  bench.state.is_controlled = false;
  const auto make = [&] { GenicamCamera(bench.options, std::make_unique<FakeGenicamDevice>(bench.state)); };
  expect_user_error(ExitCode::device, "is held by another program; close that program", make);
  EXPECT_THAT(describe(bench.module, bench.module.list[0]), HasSubstr("held by another program"));
}

TEST(GenicamCamera, ASettingThatIsNotTakenIsRefused) {
  Bench bench;
  bench.options.gain = 6;
  bench.state.faults["Gain"] = "Write timeout";
  bench.expect_refused("feature 'Gain' was asked for 6 and refused it: Write timeout; it takes 0...24");
  bench.state.faults.clear();
  bench.state.stuck["Gain"] = "5";  // taken, and not kept
  bench.expect_refused("feature 'Gain' was asked for 6 but has 5");
  bench.state.stuck.clear();
  bench.state.features["PayloadSize"].value = "7";
  bench.expect_refused("sends 7 bytes for a frame of Mono8 in 4 x 2 px, which needs 8");
  bench.state.features["PayloadSize"].readable = false;
  bench.expect_refused("feature 'PayloadSize' cannot be read");
}

TEST(GenicamCamera, AFeatureThatIsNotThereIsAnsweredWithWhatIs) {
  Bench bench;
  const auto refused = [&](const std::string& name, const std::string& words) {
    bench.options.controls = {{name, "1"}};
    bench.expect_refused("has no feature '" + name + "' now; " + words);
  };
  refused("trigger", "it has TriggerMode, TriggerSoftware, TriggerSource");  // a family
  refused("Gian", "did you mean \"Gain\"?");                                 // exchanged letters
  refused("Zzzzzzzz", "none of its 9 features has a name like it");
}

TEST(GenicamCamera, ATriggerLineIsReadBack) {
  Bench bench;
  bench.options.trigger = GenicamTrigger::line;
  bench.options.trigger_line = "Line0";
  EXPECT_EQ(bench.camera()->info().pulse_line, "Line0");
  EXPECT_EQ(bench.state.features["TriggerMode"].value, "On");
  EXPECT_EQ(bench.state.features["TriggerSource"].value, "Line0");
  bench.state.stuck["TriggerMode"] = "Off";
  bench.expect_refused("feature 'TriggerMode' was asked for On but has Off");
  bench.state.stuck = {{"TriggerSource", "Software"}};
  bench.expect_refused("feature 'TriggerSource' was asked for Line0 but has Software");
  bench.state.stuck.clear();
  bench.state.features["TriggerSource"].choices = {"Software"};
  bench.expect_refused("has no line that triggers it; leave --trigger out");
  bench.state.features["TriggerSource"].choices = {"Line0"};
  bench.state.features["TriggerSelector"] =
      FakeGenicamState::choice("AcquisitionStart", {"AcquisitionStart"});
  bench.expect_refused(
      "has no trigger that begins a frame (TriggerSelector FrameStart); it has AcquisitionSta");
}

TEST(GenicamCamera, AFrameOfALineHasTheCamerasTime) {
  Bench bench;
  bench.options.trigger = GenicamTrigger::line;
  bench.options.trigger_line = "Line0";
  const auto camera = bench.started();
  bench.state.send(1, {1, 2, 3, 4, 5, 6, 7, 8});
  bench.state.frames.back()->head.camera_ns = 77;
  const Frame frame = camera->next_frame(1s, Pixels::keep);
  EXPECT_EQ(frame.camera_ns, 77);
  EXPECT_EQ(frame.timestamp_ns, 1'000'000);
  EXPECT_EQ(std::ranges::count(bench.state.executed, "TriggerSoftware"), 0);
}

TEST(GenicamCamera, AStreamThatDoesNotBeginIsToldAndEnded) {
  Bench bench;
  const auto camera = bench.camera();
  bench.state.faults = {{"stream", "Out of memory"}};
  expect_fault(DeviceFault::Kind::stream, "does not start to stream: Out of memory",
               [&] { camera->start(); });
  bench.state.faults = {{"AcquisitionStart", "Busy"}};
  expect_fault(DeviceFault::Kind::stream, "does not begin to acquire: Busy", [&] { camera->start(); });
  EXPECT_FALSE(bench.state.streaming);
  bench.state.faults.clear();
  camera->start();
  EXPECT_TRUE(bench.state.streaming);
}

TEST(GenicamCamera, AFrameIsItsBytes) {
  Bench bench;
  const auto camera = bench.started();
  bench.state.send(1, {1, 2, 3, 4, 250, 251, 252, 255});
  const Frame frame = camera->next_frame(1s, Pixels::keep);
  EXPECT_EQ(frame.fault, FrameFault::none);
  EXPECT_THAT(frame.dn.data, ElementsAre(1, 2, 3, 4, 250, 251, 252, 255));
  EXPECT_THAT(bench.state.executed, Contains("TriggerSoftware"));
  bench.state.send(2, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_TRUE(camera->next_frame(1s, Pixels::drop).dn.empty());
}

TEST(GenicamCamera, ADamagedFrameIsMarkedAndTheStreamGoesOn) {
  Bench bench;
  const auto camera = bench.started();
  std::uint64_t id = 0;
  const auto fault_of = [&](const std::function<void(FakeBuffer&)>& damage) {
    bench.state.send(++id, {1, 2, 3, 4, 5, 6, 7, 8});
    damage(*bench.state.frames.back());
    const Frame frame = camera->next_frame(1s, Pixels::keep);
    EXPECT_EQ(frame.dn.empty(), frame.fault != FrameFault::none);
    EXPECT_EQ(frame.sequence, id);
    return frame.fault;
  };
  using State = GenicamBuffer::State;
  EXPECT_EQ(fault_of([](FakeBuffer&) {}), FrameFault::none);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.head.state = State::incomplete; }), FrameFault::missing_packets);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.head.state = State::wrong_length; }), FrameFault::wrong_length);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.head.state = State::aborted; }), FrameFault::error_flag);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.head.width = 5; }), FrameFault::wrong_length);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.head.pixel_format = 0; }), FrameFault::undecodable);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.bytes.pop_back(); }), FrameFault::wrong_length);
  EXPECT_EQ(fault_of([](FakeBuffer& b) { b.bytes.clear(); }), FrameFault::wrong_length);
  EXPECT_EQ(fault_of([](FakeBuffer&) {}), FrameFault::none);
}

// What is still under way when the time is over must not be taken for the next frame.
TEST(GenicamCamera, AFrameThatDoesNotComeInTimeBeginsANewStream) {
  Bench bench;
  const auto camera = bench.started();
  bench.state.executed.clear();
  expect_fault(DeviceFault::Kind::timeout, "no frame in time",
               [&] { camera->next_frame(1ms, Pixels::keep); });
  EXPECT_THAT(bench.state.executed, ElementsAre("TriggerSoftware"));
  bench.state.send(1, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_EQ(camera->next_frame(1s, Pixels::keep).fault, FrameFault::none);
  EXPECT_THAT(bench.state.executed,
              ElementsAre("TriggerSoftware", "AcquisitionStop", "AcquisitionStart", "TriggerSoftware"));
}

TEST(GenicamCamera, ACameraThatIsGoneIsTold) {
  Bench bench;
  auto camera = bench.started();
  bench.state.faults = {{"TriggerSoftware", "Timeout"}};
  expect_fault(DeviceFault::Kind::stream, "takes no trigger: Timeout",
               [&] { camera->next_frame(1ms, Pixels::keep); });
  bench.state.is_silent = true;
  camera = nullptr;
  camera = bench.started();
  expect_fault(DeviceFault::Kind::gone, "takes no trigger: Timeout: the camera does not answer any more",
               [&] { camera->next_frame(1ms, Pixels::keep); });
  bench.state.is_silent = false;
  bench.state.faults.clear();
  camera = nullptr;
  camera = bench.started();
  camera->check_input();
  bench.state.is_lost = true;
  bench.state.executed.clear();
  expect_fault(DeviceFault::Kind::gone, "no frame in time: control of the camera was lost",
               [&] { camera->next_frame(10s, Pixels::keep); });
  expect_fault(DeviceFault::Kind::gone, "control of the camera was lost", [&] { camera->check_input(); });
  camera->stop();
  EXPECT_FALSE(bench.state.streaming);
  EXPECT_THAT(bench.state.executed, Not(Contains("AcquisitionStop")));  // nobody is there to hear it
}

TEST(GenicamCamera, CountsOfAllStreamsAreInTheRecord) {
  Bench bench;
  const auto camera = bench.started();
  bench.state.counts = {.underruns = 1, .missing_packets = 20, .resend_requests = 3, .resent_packets = 4};
  camera->start();  // which ends the first stream
  camera->stop();
  const Provenance told = camera->info().provenance;
  EXPECT_EQ(told.at("underruns"), "2");
  EXPECT_EQ(told.at("packets_missing"), "40");
  EXPECT_EQ(told.at("packets_asked_again"), "6");
  EXPECT_EQ(told.at("packets_resent"), "8");
}

}  // namespace
}  // namespace fringetwin::testing::genicam_camera_test
