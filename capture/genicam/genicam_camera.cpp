// SPDX-License-Identifier: Apache-2.0
#include "capture/genicam/genicam_camera.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <thread>

#include "capture/genicam/genicam_region.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::capture {
namespace {

bool is_settled(const std::string& ptp_status) { return ptp_status == "Master" || ptp_status == "Slave"; }

using namespace std::chrono_literals;

constexpr double kUsPerMs = 1000.0;

/// Kept in the record of a capture where the camera has them, besides what the user named.
const std::vector<std::string> kRecordedFeatures = {"PixelFormat",
                                                    "Width",
                                                    "Height",
                                                    "OffsetX",
                                                    "OffsetY",
                                                    "BinningHorizontal",
                                                    "BinningVertical",
                                                    "DecimationHorizontal",
                                                    "DecimationVertical",
                                                    "ReverseX",
                                                    "ReverseY",
                                                    "ExposureMode",
                                                    "ExposureTime",
                                                    "ExposureTimeAbs",
                                                    "Gain",
                                                    "GainRaw",
                                                    "BlackLevel",
                                                    "BlackLevelRaw",
                                                    "Gamma",
                                                    "GammaEnable",
                                                    "LUTEnable",
                                                    "SensorShutterMode",
                                                    "AcquisitionMode",
                                                    "AcquisitionFrameRate",
                                                    "TriggerMode",
                                                    "TriggerSource",
                                                    "TriggerActivation",
                                                    "TriggerDelay",
                                                    "TriggerDelayAbs",
                                                    "DeviceTemperature",
                                                    "DeviceFirmwareVersion",
                                                    "DeviceVersion"};

FrameFault fault_of(GenicamBuffer::State state) {
  switch (state) {
    case GenicamBuffer::State::whole:
      return FrameFault::none;
    case GenicamBuffer::State::incomplete:
      return FrameFault::missing_packets;
    case GenicamBuffer::State::wrong_length:
      return FrameFault::wrong_length;
    case GenicamBuffer::State::aborted:
      return FrameFault::error_flag;
  }
  return FrameFault::error_flag;
}

}  // namespace

GenicamCamera::GenicamCamera(GenicamCameraOptions options, std::unique_ptr<GenicamDevice> device,
                             std::map<std::string, std::string> provenance)
    : options_(std::move(options)),
      device_(std::move(device)),
      settings_(*device_, options_.name),
      provenance_(std::move(provenance)),
      recorded_(kRecordedFeatures) {
  check_controls(options_);
  if (!device_->controlled())
    throw settings_.refusal("is held by another program",
                            "close that program; one that was killed lets go after a few seconds");
  set_up();
}

// --- settings

// What the user set is looked at again at the end: one feature may move another.
void GenicamCamera::set_up() {
  std::vector<std::pair<std::string, std::string>> wanted;
  std::set<std::string> named;
  for (const auto& [name, value] : options_.controls) {
    const std::string own = settings_.own_name(name);
    named.insert(own);
    if (own.starts_with("Trigger"))
      trigger_controls_.emplace_back(own, value);  // of the kind that is selected then
    else if (own != "OffsetX" && own != "OffsetY")
      wanted.emplace_back(own, value);
  }
  if (options_.gain) {
    const std::string gain = settings_.first_of({"Gain", "GainRaw"});
    if (gain.empty()) throw settings_.refusal("has no gain", "leave the gain out");
    wanted.emplace_back(gain, std::to_string(*options_.gain));
  }
  const std::vector<std::string> automatics = settings_.turn_off_automatics(named);
  settings_.set_where_there("AcquisitionMode", "Continuous");
  if (!named.contains("ExposureMode")) settings_.set_where_there("ExposureMode", "Timed");
  reset_geometry(settings_, named);
  for (const auto& [name, value] : wanted) settings_.set(name, value);
  layout_ = set_region_and_format(settings_, options_);
  exposure_feature_ = settings_.first_of({"ExposureTime", "ExposureTimeAbs"});
  if (!exposure_feature_.empty()) exposure_ms_ = settings_.number(exposure_feature_) / kUsPerMs;
  set_up_trigger();
  for (const auto* list : {&wanted, &trigger_controls_})
    for (const auto& [name, value] : *list) settings_.verify(name, value);
  recorded_.insert(recorded_.end(), named.begin(), named.end());
  recorded_.insert(recorded_.end(), automatics.begin(), automatics.end());
  provenance_.merge(settings_.provenance(recorded_));
  provenance_["format"] = layout_.format->name;
  provenance_["size"] = fmt::format("{}x{}", layout_.width, layout_.height);
  if (layout_.format->is_mosaic()) provenance_["mosaic"] = layout_.format->mosaic;
  if (layout_.shift > 0) provenance_["shift"] = std::to_string(layout_.shift);
}

void GenicamCamera::set_up_trigger() {
  const GenicamFeature selector = settings_.feature("TriggerSelector");
  for (const std::string& kind : selector.choices) {
    settings_.set("TriggerSelector", kind);
    settings_.set_where_there("TriggerMode", "Off");
  }
  if (selector.choices.empty()) settings_.set_where_there("TriggerMode", "Off");
  if (selector.has_choice("FrameStart")) settings_.set("TriggerSelector", "FrameStart");
  if (options_.trigger == GenicamTrigger::line) return set_up_line();
  triggered_ = options_.trigger == GenicamTrigger::software &&
               settings_.feature("TriggerSource").has_choice("Software") &&
               settings_.feature("TriggerSoftware").there();
  if (triggered_) {
    if (options_.rate_hz)
      throw settings_.refusal("takes a frame for each trigger, so that no rate can be set",
                              "leave the rate out, or add --trigger off");
    settings_.set("TriggerSource", "Software");
    set_trigger_controls();
    settings_.set("TriggerMode", "On");
    return;
  }
  set_trigger_controls();
  set_up_rate();
}

void GenicamCamera::set_trigger_controls() {
  for (const auto& [name, value] : trigger_controls_) settings_.set(name, value);
}

// Cameras with several kinds of triggers have one that begins a frame; what was set is read back, TriggerMode
// last: nothing triggers by the line that was set before.
void GenicamCamera::set_up_line() {
  const GenicamFeature selector = settings_.feature("TriggerSelector");
  if (selector.there() && !selector.has_choice("FrameStart"))
    throw settings_.refusal("has no trigger that begins a frame (TriggerSelector FrameStart)",
                            fmt::format("it has {}", range_text(selector)));
  const GenicamFeature source = settings_.feature("TriggerSource");
  std::string own;
  std::vector<std::string> lines;
  for (const std::string& choice : source.choices) {
    if (choice == "Software") continue;
    lines.push_back(choice);
    if (lower_case(choice) == lower_case(options_.trigger_line)) own = choice;
  }
  if (lines.empty() || !settings_.feature("TriggerMode").has_choice("On"))
    throw settings_.refusal("has no line that triggers it", "leave --trigger out");
  if (own.empty())
    throw settings_.refusal(fmt::format("has no trigger line '{}'", options_.trigger_line),
                            fmt::format("it has {}", fmt::join(lines, ", ")));
  if (options_.rate_hz)
    throw settings_.refusal("takes a frame for each pulse, so that no rate can be set", "leave the rate out");
  settings_.set_where_there("AcquisitionFrameRateEnable", "false");
  settings_.set("TriggerSource", own);
  set_trigger_controls();
  settings_.set("TriggerMode", "On");
  settings_.verify("TriggerSource", own);
  pulse_line_ = own;
}

void GenicamCamera::set_up_rate() {
  settings_.set_where_there("AcquisitionFrameRateEnable", options_.rate_hz ? "true" : "false");
  const std::string rate = settings_.first_of({"AcquisitionFrameRate", "AcquisitionFrameRateAbs"});
  if (options_.rate_hz) {
    if (rate.empty()) throw settings_.refusal("has no rate to set", "leave the rate out");
    settings_.set(rate, *options_.rate_hz);
  }
  const std::string resulting = settings_.first_of({"ResultingFrameRate", "AcquisitionResultingFrameRate"});
  if (const std::string& told = resulting.empty() ? rate : resulting; !told.empty())
    if (const double hz = settings_.number(told); hz > 0.0) period_ms_ = 1000.0 / hz;
}

std::optional<ExposureRange> GenicamCamera::exposure_range() const {
  if (exposure_feature_.empty()) return std::nullopt;
  const GenicamFeature feature = settings_.feature(exposure_feature_);
  return ExposureRange{feature.min / kUsPerMs, feature.max / kUsPerMs, feature.step / kUsPerMs};
}

// To the nearest that the camera has, which is returned: who asked looks at it.
double GenicamCamera::set_exposure_ms(double exposure_ms) {
  if (exposure_feature_.empty()) return CameraDevice::set_exposure_ms(exposure_ms);
  const GenicamFeature feature = settings_.feature(exposure_feature_);
  double exposure_us = exposure_ms * kUsPerMs;
  if (feature.step > 0.0)
    exposure_us = feature.min + std::round((exposure_us - feature.min) / feature.step) * feature.step;
  settings_.set(exposure_feature_, exposure_us);
  exposure_ms_ = settings_.number(exposure_feature_) / kUsPerMs;
  provenance_["control." + exposure_feature_] = fmt::format("{}", *exposure_ms_ * kUsPerMs);
  return *exposure_ms_;
}

// --- stream

void GenicamCamera::throw_fault(DeviceFault::Kind otherwise, const std::string& doing) {
  const bool lost = device_->lost();
  gone_ = lost || !device_->answers();
  if (gone_)
    throw DeviceFault(DeviceFault::Kind::gone,
                      fmt::format("{}: {}: {}", options_.name, doing,
                                  lost ? "control of the camera was lost (its power, its cable, or another "
                                         "program took it)"
                                       : "the camera does not answer any more"));
  throw DeviceFault(otherwise, fmt::format("{}: {}", options_.name, doing));
}

void GenicamCamera::start() {
  stop();
  await_shared_clock();
  std::string fault;
  if (!device_->stream_on(options_.buffers, &fault))
    throw_fault(DeviceFault::Kind::stream, "does not start to stream: " + fault);
  streaming_ = true;
  blocks_ = BlockCount();
  clock_ = TriggerClock();
  last_stamp_ns_ = 0;
  if (!device_->execute("AcquisitionStart", &fault)) {
    stop();
    throw_fault(DeviceFault::Kind::stream, "does not begin to acquire: " + fault);
  }
}

void GenicamCamera::stop() noexcept {
  trigger_sent_ns_.reset();
  unanswered_ = false;
  if (!streaming_) return;
  streaming_ = false;
  std::string ignored;
  if (!gone_ && !device_->lost()) device_->execute("AcquisitionStop", &ignored);
  device_->stream_off();
  note_counts();
}

void GenicamCamera::note_counts() {
  const GenicamCounts now = device_->counts();
  counts_.underruns += now.underruns;
  counts_.missing_packets += now.missing_packets;
  counts_.resend_requests += now.resend_requests;
  counts_.resent_packets += now.resent_packets;
}

void GenicamCamera::trigger() {
  if (unanswered_) start();
  if (!triggered_ || trigger_sent_ns_) return;
  if (!streaming_) throw DeviceFault(DeviceFault::Kind::stream, options_.name + " does not stream");
  while (device_->next(0ms)) {  // frames that nobody asked for
  }
  std::string fault;
  trigger_sent_ns_ = now_ns();
  if (!device_->execute("TriggerSoftware", &fault))
    throw_fault(DeviceFault::Kind::stream, "takes no trigger: " + fault);
}

std::optional<GenicamBuffer> GenicamCamera::await_buffer(std::chrono::milliseconds timeout) {
  // In parts: a lost camera is noticed, and no command waits for one, long before a long exposure ends.
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (auto buffer = device_->next(std::clamp<std::chrono::milliseconds>(left, 0ms, 100ms))) return buffer;
    if (left <= 0ms || device_->lost()) return std::nullopt;
  }
}

Frame GenicamCamera::next_frame(std::chrono::milliseconds timeout, Pixels pixels) {
  if (!streaming_) throw DeviceFault(DeviceFault::Kind::stream, options_.name + " does not stream");
  trigger();
  const std::optional<GenicamBuffer> buffer = await_buffer(timeout);
  if (buffer) return to_frame(*buffer, pixels);
  // Its frame may come yet and must not be taken for another's: only a new stream knows nothing of it.
  unanswered_ = triggered_;
  throw_fault(DeviceFault::Kind::timeout, "no frame in time");
}

Frame GenicamCamera::to_frame(const GenicamBuffer& buffer, Pixels pixels) {
  Frame frame{.timestamp_ns = buffer.came_ns,
              .flags = static_cast<std::uint32_t>(buffer.status),
              .camera_ns = buffer.camera_ns};
  frame.fault = fault_of(buffer.state);
  // Damaged, it may have the id and the times of another.
  bool trusted = frame.fault == FrameFault::none;
  frame.sequence =
      trusted ? blocks_.number(buffer.block_id) : blocks_.number_of_damaged(buffer.block_id, &trusted);
  if (triggered_ && frame.fault == FrameFault::none)
    frame.timestamp_ns = clock_.begin_ns(buffer.camera_ns, *trigger_sent_ns_);
  else if (triggered_)
    frame.timestamp_ns = *trigger_sent_ns_;
  else  // by microseconds
    frame.timestamp_ns = trusted ? std::max(buffer.came_ns, last_stamp_ns_ + 1) : last_stamp_ns_ + 1;
  last_stamp_ns_ = frame.timestamp_ns;
  trigger_sent_ns_.reset();
  if (frame.fault != FrameFault::none) return frame;
  UnpackedFrame unpacked = unpack(buffer, pixels);
  frame.dn = std::move(unpacked.dn);
  frame.fault = unpacked.fault;
  return frame;
}

UnpackedFrame GenicamCamera::unpack(const GenicamBuffer& buffer, Pixels pixels) const {
  if (buffer.width != layout_.width || buffer.height != layout_.height) return {{}, FrameFault::wrong_length};
  if (buffer.pixel_format != layout_.format->code) return {{}, FrameFault::undecodable};
  PfncLayout layout = layout_;
  layout.line_padding = static_cast<std::size_t>(std::max(buffer.line_padding, 0));
  if (pixels == Pixels::drop) return {{}, check_length(buffer.bytes.size(), layout)};
  return unpack_pfnc(buffer.bytes, layout);
}

void GenicamCamera::drain() {
  if (!streaming_) return;
  if (trigger_sent_ns_ || unanswered_) {  // its frame is on the way
    start();
    return;
  }
  while (device_->next(0ms)) {
  }
}

void GenicamCamera::check_input() {
  if (device_->lost()) throw_fault(DeviceFault::Kind::gone, "recording");
}

std::string GenicamCamera::ptp_status() const {
  const std::string enable = settings_.first_of({"PtpEnable", "GevIEEE1588"});
  if (enable.empty() || lower_case(settings_.feature(enable).value) != "true") return "";
  const std::string status = settings_.first_of({"PtpStatus", "GevIEEE1588Status"});
  return status.empty() ? "unknown" : settings_.feature(status).value;
}

// A clock that has just been switched on takes some seconds to agree with the others.
void GenicamCamera::await_shared_clock() {
  const auto end = std::chrono::steady_clock::now() + options_.ptp_wait;
  for (ptp_ = ptp_status(); !ptp_.empty() && !is_settled(ptp_); ptp_ = ptp_status()) {
    if (std::chrono::steady_clock::now() > end)
      return warn(fmt::format(
          "{}: its clock does not follow the network's (PTP: {}); its times are taken for its own",
          options_.name, ptp_));
    throw_if_cancelled();
    std::this_thread::sleep_for(100ms);
  }
}

CameraInfo GenicamCamera::info() const {
  CameraInfo info{.device = options_.name,
                  .width = layout_.width,
                  .height = layout_.height,
                  .bit_depth = layout_.bit_depth(),
                  .period_ms = period_ms_,
                  .timestamp_at_exposure_start = triggered_,
                  .triggered = triggered_,
                  .provenance = provenance_,
                  .pulse_line = pulse_line_};
  info.provenance["trigger"] = triggered_            ? "software, one for each frame"
                               : pulse_line_.empty() ? "none, frames come by themselves"
                                                     : pulse_line_ + ", a pulse for each frame";
  info.provenance["time_stamps"] = triggered_ ? "taken by this program as it triggers"
                                              : "taken by this program as a frame's first packet comes";
  info.has_shared_clock = is_settled(ptp_);
  if (!ptp_.empty()) info.provenance["ptp"] = ptp_;
  info.provenance["underruns"] = std::to_string(counts_.underruns);
  info.provenance["packets_missing"] = std::to_string(counts_.missing_packets);
  info.provenance["packets_asked_again"] = std::to_string(counts_.resend_requests);
  info.provenance["packets_resent"] = std::to_string(counts_.resent_packets);
  return info;
}

}  // namespace fringetwin::capture
