// SPDX-License-Identifier: Apache-2.0
// A GenICam module and its camera in software: what the camera has, and what it does wrong, is set by the
// test. The camera's state is the test's, so that it outlives the camera.
#pragma once
#include <deque>
#include <map>

#include "capture/device/pfnc_format.hpp"
#include "capture/genicam/genicam_module.hpp"
#include "tests/support/capture/bytes.hpp"

namespace fringetwin::testing {

/// A frame yet to come; nothing in its place: none comes in time.
struct FakeBuffer {
  capture::GenicamBuffer head;
  Bytes bytes;
};

struct FakeGenicamState {
  using Kind = capture::GenicamFeature::Kind;

  // --- the camera, open to the test: 4 x 2 px of Mono8, triggered by software
  std::map<std::string, capture::GenicamFeature> features = {
      {"PixelFormat", choice("Mono8", {"Mono8", "RGB8"})},
      {"Width", number(Kind::integer, "4", 1, 4)},
      {"Height", number(Kind::integer, "2", 1, 2)},
      {"PayloadSize", number(Kind::integer, "8", 0, 0)},
      {"ExposureTime", number(Kind::number, "5000", 10, 1e6)},
      {"Gain", number(Kind::number, "0", 0, 24)},
      {"TriggerMode", choice("Off", {"Off", "On"})},
      {"TriggerSource", choice("Line0", {"Line0", "Software"})},
      {"TriggerSoftware", feature(Kind::command, "")}};
  std::map<std::string, std::string> stuck = {};   ///< features that take a value and have this one
  std::map<std::string, std::string> faults = {};  ///< of set(), execute() by name, of "stream"
  std::deque<std::optional<FakeBuffer>> frames = {};
  bool is_controlled = true, is_lost = false, is_silent = false;
  capture::GenicamCounts counts = {};

  // --- what was done to it
  std::vector<std::string> executed = {};
  std::vector<std::string> written = {};  ///< features, in the order in which they were set
  bool streaming = false;

  static capture::GenicamFeature feature(Kind kind, std::string value) {
    capture::GenicamFeature out;
    out.kind = kind;
    out.writable = true;
    out.readable = kind != Kind::command;
    out.value = std::move(value);
    return out;
  }
  static capture::GenicamFeature choice(std::string value, std::vector<std::string> choices) {
    capture::GenicamFeature out = feature(Kind::choice, std::move(value));
    out.choices = std::move(choices);
    return out;
  }
  static capture::GenicamFeature number(Kind kind, std::string value, double min, double max) {
    capture::GenicamFeature out = feature(kind, std::move(value));
    out.min = min;
    out.max = max;
    out.step = kind == Kind::integer ? 1.0 : 0.0;
    return out;
  }
  /// Adds a whole frame of these gray values.
  void send(std::uint64_t block_id, std::initializer_list<int> dn) {
    capture::GenicamBuffer head;
    head.block_id = block_id;
    head.came_ns = static_cast<capture::TimeNs>(block_id) * 1'000'000;
    head.pixel_format = capture::pfnc_format_of_name("Mono8")->code;
    head.width = 4;
    head.height = 2;
    frames.emplace_back(FakeBuffer{head, bytes_of(dn)});
  }
};

class FakeGenicamDevice final : public capture::GenicamDevice {
 public:
  explicit FakeGenicamDevice(FakeGenicamState& state) : state_(state) {}

  bool controlled() const override { return state_.is_controlled; }
  bool lost() const override { return state_.is_lost; }
  bool answers() override { return !state_.is_silent && !state_.is_lost; }

  std::vector<std::string> feature_names() override {
    std::vector<std::string> names;
    for (const auto& [name, feature] : state_.features) names.push_back(name);
    return names;
  }
  capture::GenicamFeature feature(const std::string& name) override {
    const auto at = state_.features.find(name);
    return at != state_.features.end() ? at->second : capture::GenicamFeature{};
  }
  bool set(const std::string& name, const std::string& value, std::string* fault) override {
    if (fails(name, fault)) return false;
    state_.written.push_back(name);
    const auto stuck = state_.stuck.find(name);
    state_.features.at(name).value = stuck != state_.stuck.end() ? stuck->second : value;
    return true;
  }
  bool execute(const std::string& command, std::string* fault) override {
    state_.executed.push_back(command);
    return !fails(command, fault);
  }

  bool stream_on(unsigned, std::string* fault) override {
    state_.streaming = !fails("stream", fault);
    return state_.streaming;
  }
  void stream_off() noexcept override { state_.streaming = false; }
  /// Frames come when they are waited for, not before.
  std::optional<capture::GenicamBuffer> next(std::chrono::milliseconds timeout) override {
    if (!state_.streaming || timeout.count() == 0 || state_.frames.empty()) return std::nullopt;
    held_ = std::move(state_.frames.front());
    state_.frames.pop_front();
    if (!held_) return std::nullopt;
    held_->head.bytes = held_->bytes;
    return held_->head;
  }
  capture::GenicamCounts counts() override { return state_.counts; }

 private:
  bool fails(const std::string& what, std::string* fault) const {
    const auto at = state_.faults.find(what);
    if (at != state_.faults.end()) *fault = at->second;
    return at != state_.faults.end();
  }

  FakeGenicamState& state_;
  std::optional<FakeBuffer> held_;
};

class FakeGenicamModule final : public capture::GenicamModule {
 public:
  std::vector<capture::GenicamListed> list = {{"Fake-1", "Fake", "One", "S1", "GigEVision", "192.168.0.7"},
                                              {"Fake-2", "Fake", "Two", "", "USB3Vision", ""}};
  std::string fault;  ///< of open(); "": none
  FakeGenicamState state;

  std::string version() const override { return "Fake 1.0"; }
  std::vector<capture::GenicamListed> devices() override { return list; }
  std::unique_ptr<capture::GenicamDevice> open(const std::string&, std::string* why) override {
    if (fault.empty()) return std::make_unique<FakeGenicamDevice>(state);
    *why = fault;
    return nullptr;
  }
};

}  // namespace fringetwin::testing
