// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_camera.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <thread>

namespace fringetwin::capture {
namespace {

using namespace std::chrono_literals;

constexpr int kStartTries = 4;
constexpr auto kAfterErrorEvent = 2ms;  // some drivers raise one and deliver all the same

bool at_exposure_start(std::uint32_t flags) {
  return is_monotonic(flags) && (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
}

std::string time_stamps_text(std::uint32_t flags) {
  if (!is_monotonic(flags)) return "taken by this program when it gets a frame: the driver gives none";
  return at_exposure_start(flags) ? "driver, start of exposure" : "driver, end of frame";
}

}  // namespace

V4l2Camera::V4l2Camera(V4l2CameraOptions options, std::shared_ptr<V4l2Api> api)
    : options_(std::move(options)),
      device_(std::move(api), options_.device, V4L2_CAP_VIDEO_CAPTURE),
      agreed_(agree_on_capture(device_, options_.format)),
      controls_(device_),
      exposure_(find_exposure(controls_, agreed_.layout.width)),
      buffers_(device_, V4L2_BUF_TYPE_VIDEO_CAPTURE) {
  apply_controls();
}

// --- controls

// V4L2_CID_EXPOSURE has the driver's unit: with sensors lines, whose time follows from blanking and pixel
// rate.
std::optional<V4l2Camera::Exposure> V4l2Camera::find_exposure(const V4l2Controls& controls, int width) {
  constexpr double kUnitOfAbsoluteMs = 0.1;
  if (const V4l2Control* absolute = controls.find(V4L2_CID_EXPOSURE_ABSOLUTE))
    return Exposure{absolute, kUnitOfAbsoluteMs};
  const V4l2Control* lines = controls.find(V4L2_CID_EXPOSURE);
  const V4l2Control* blanking = controls.find(V4L2_CID_HBLANK);
  const V4l2Control* pixel_rate = controls.find(V4L2_CID_PIXEL_RATE);
  if (lines == nullptr || blanking == nullptr || pixel_rate == nullptr) return std::nullopt;
  const auto rate = static_cast<double>(controls.get(*pixel_rate));
  if (rate <= 0.0) return std::nullopt;
  return Exposure{lines, 1000.0 * (width + static_cast<double>(controls.get(*blanking))) / rate};
}

// What the user set is looked at again at the end: one control may move another.
void V4l2Camera::apply_controls() {
  std::vector<std::pair<const V4l2Control*, std::string>> wanted;
  std::set<std::uint32_t> kept;
  for (const auto& [name, value] : options_.controls) {
    wanted.emplace_back(&controls_.named(name), value);
    kept.insert(wanted.back().first->id);
  }
  if (options_.gain) {
    const V4l2Control* gain = controls_.find(V4L2_CID_GAIN);
    if (gain == nullptr) gain = controls_.find(V4L2_CID_ANALOGUE_GAIN);
    if (gain == nullptr) throw device_.refusal("has no gain control", "leave the gain out");
    wanted.emplace_back(gain, std::to_string(*options_.gain));
  }
  controls_.turn_off_automatics(kept);
  for (const auto& [control, value] : wanted) controls_.set(*control, value);
  if (options_.exposure_ms) set_exposure_ms(*options_.exposure_ms);
  for (const auto& [control, value] : wanted) controls_.verify(*control, value);
  control_values_ = controls_.provenance();
}

std::optional<ExposureRange> V4l2Camera::exposure_range() const {
  if (!exposure_) return std::nullopt;
  const auto& [control, unit_ms] = *exposure_;
  return ExposureRange{static_cast<double>(control->min) * unit_ms,
                       static_cast<double>(control->max) * unit_ms,
                       static_cast<double>(control->step) * unit_ms};
}

std::optional<double> V4l2Camera::exposure_ms() const {
  if (!exposure_) return std::nullopt;
  return static_cast<double>(controls_.get(*exposure_->control)) * exposure_->unit_ms;
}

double V4l2Camera::set_exposure_ms(double exposure_ms) {
  if (!exposure_) {
    if (const V4l2Control* own = controls_.find(V4L2_CID_EXPOSURE))
      throw device_.refusal("has an exposure control in the driver's own unit, not in ms",
                            fmt::format("set control '{}' instead, it takes {}", own->key, own->range()));
    return CameraDevice::set_exposure_ms(exposure_ms);
  }
  const auto& [control, unit_ms] = *exposure_;
  const ExposureRange range = *exposure_range();
  const double slack = 0.5 * unit_ms;
  if (exposure_ms < range.min_ms - slack || exposure_ms > range.max_ms + slack)
    throw device_.refusal(fmt::format("an exposure of {} ms was asked for, control '{}' has {:g}...{:g} ms",
                                      exposure_ms, control->key, range.min_ms, range.max_ms));
  const auto steps = static_cast<std::int64_t>(std::llround((exposure_ms - range.min_ms) / range.step_ms));
  controls_.set(*control, std::min(control->min + steps * control->step, control->max));
  const std::int64_t value = controls_.get(*control);
  control_values_["control." + control->key] = control->value_text(value);
  return static_cast<double>(value) * unit_ms;
}

// --- stream

int V4l2Camera::try_start() {
  int result = buffers_.allocate(options_.buffers);
  for (unsigned i = 0; result == 0 && i < buffers_.size(); ++i) result = buffers_.queue(i);
  if (result == 0) result = buffers_.stream_on();
  if (result != 0) buffers_.release();
  return result;
}

void V4l2Camera::start() {
  stop();
  for (int attempt = 1;; ++attempt) {
    const int result = try_start();
    if (result == 0) break;
    if (is_gone(result)) throw_device_fault(device_, result, "start");
    ++refused_starts_;
    if (attempt == kStartTries)
      throw device_.refusal(
          fmt::format("does not start to stream after {} tries: {}", kStartTries, error_text(result)),
          result == -EBUSY ? "another program has it" : "");
    std::this_thread::sleep_for(options_.start_pause);
  }
  streaming_ = true;
  buffer_flags_ = buffers_.flags();
}

void V4l2Camera::stop() noexcept {
  if (!streaming_) return;
  streaming_ = false;
  buffers_.release();
}

// After the deadline the reason is looked for: a lost device and a lost signal say so themselves.
void V4l2Camera::await_frame(std::chrono::steady_clock::time_point deadline) const {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
  const int events = device_.poll(POLLIN, std::max<std::chrono::milliseconds>(left, 0ms));
  if (events < 0) throw_device_fault(device_, events, "poll");
  if ((events & POLLIN) != 0) return;
  if (events != 0 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kAfterErrorEvent);
    return;
  }
  if (const std::string trouble = input_trouble(device_, agreed_); !trouble.empty())
    throw DeviceFault(DeviceFault::Kind::no_signal, device_.path() + ": " + trouble);
  v4l2_capability capability{};
  if (const int result = device_.call(VIDIOC_QUERYCAP, capability); is_gone(result))
    throw_device_fault(device_, result, "poll");
  throw DeviceFault(DeviceFault::Kind::timeout, device_.path() + ": no frame in time");
}

Frame V4l2Camera::next_frame(std::chrono::milliseconds timeout, Pixels pixels) {
  if (!streaming_) throw DeviceFault(DeviceFault::Kind::stream, device_.path() + " does not stream");
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  v4l2_buffer buffer{};
  for (;;) {
    await_frame(deadline);
    const int result = buffers_.dequeue(buffer);
    if (result == 0) break;
    if (result != -EAGAIN) throw_device_fault(device_, result, "reading a frame");
  }
  buffer_flags_ = buffer.flags;
  Frame frame = to_frame(buffer, pixels);
  if (const int result = buffers_.queue(buffer.index); result != 0)
    throw_device_fault(device_, result, "queueing a buffer");
  return frame;
}

Frame V4l2Camera::to_frame(const v4l2_buffer& buffer, Pixels pixels) const {
  Frame frame{.sequence = buffer.sequence,
              .timestamp_ns = stamped_ns(buffer).value_or(now_ns()),
              .flags = buffer.flags};
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
    frame.fault = FrameFault::error_flag;
    return frame;
  }
  const std::span<std::byte> whole = buffers_.bytes(buffer.index);
  if (buffer.bytesused > whole.size()) {
    frame.fault = FrameFault::wrong_length;
    return frame;
  }
  const std::span<const std::byte> used = whole.first(buffer.bytesused);
  if (pixels == Pixels::drop) {
    frame.fault = check_length(used, agreed_.layout);
    return frame;
  }
  UnpackedFrame unpacked = unpack_frame(used, agreed_.layout);
  frame.dn = std::move(unpacked.dn);
  frame.fault = unpacked.fault;
  return frame;
}

void V4l2Camera::drain() {
  if (!streaming_) return;
  for (;;) {
    v4l2_buffer buffer{};
    const int taken = buffers_.dequeue(buffer);
    if (taken == -EAGAIN) return;
    if (taken != 0) throw_device_fault(device_, taken, "reading a frame");
    if (const int given = buffers_.queue(buffer.index); given != 0)
      throw_device_fault(device_, given, "queueing a buffer");
  }
}

void V4l2Camera::check_input() {
  if (const std::string trouble = input_trouble(device_, agreed_); !trouble.empty())
    throw DeviceFault(DeviceFault::Kind::no_signal, device_.path() + ": " + trouble);
}

CameraInfo V4l2Camera::info() const {
  CameraInfo info{.device = options_.device,
                  .width = agreed_.layout.width,
                  .height = agreed_.layout.height,
                  .bit_depth = agreed_.layout.bit_depth(),
                  .period_ms = agreed_.period_ms,
                  .provenance = device_.provenance()};
  info.provenance.insert(agreed_.provenance.begin(), agreed_.provenance.end());
  info.provenance.insert(control_values_.begin(), control_values_.end());
  if (const char* mosaic = traits(agreed_.layout.format).mosaic; *mosaic != '\0')
    info.provenance["mosaic"] = mosaic;
  if (agreed_.layout.shift > 0) info.provenance["shift"] = std::to_string(agreed_.layout.shift);
  if (refused_starts_ > 0) info.provenance["refused_starts"] = std::to_string(refused_starts_);
  if (buffer_flags_) {
    info.timestamp_at_exposure_start = at_exposure_start(*buffer_flags_);
    info.provenance["time_stamps"] = time_stamps_text(*buffer_flags_);
  }
  return info;
}

}  // namespace fringetwin::capture
