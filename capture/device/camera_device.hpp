// SPDX-License-Identifier: Apache-2.0
// The interface of a camera as the recording sees it: numbered, time-stamped frames in DN, faults told apart;
// and the rig of them, each under the name that the twin gives it.
#pragma once
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::capture {

using ImageU16 = Image<std::uint16_t>;

/// CLOCK_MONOTONIC in ns, for cameras and displays alike; a simulated rig has a clock of its own.
using TimeNs = std::int64_t;
TimeNs steady_now_ns();
inline constexpr double kNsPerMs = 1e6;
inline TimeNs to_ns(double ms) { return static_cast<TimeNs>(std::llround(ms * kNsPerMs)); }

/// The faults that make a single frame useless; the stream goes on.
enum class FrameFault {
  none,
  error_flag,       ///< the driver marked its data as corrupt
  wrong_length,     ///< fewer or more bytes than the format has
  undecodable,      ///< a damaged JPEG
  missing_packets,  ///< a network or USB camera's data came with holes
};
const char* frame_fault_name(FrameFault fault);  ///< "none", "error flag", "wrong length" ...

struct Frame {
  ImageU16 dn = {};            ///< empty when faulty or not asked for
  std::uint32_t sequence = 0;  ///< the driver's own count: a gap is a lost frame
  TimeNs timestamp_ns = 0;     ///< the driver's, start or end of the exposure (CameraInfo)
  std::uint32_t flags = 0;     ///< V4L2_BUF_FLAG_..., or Aravis' buffer status
  FrameFault fault = FrameFault::none;
  TimeNs camera_ns = 0;  ///< on the camera's own clock; 0: it gives none
};

/// The order of one camera's frames by the driver's own count and time stamps.
class FrameOrder {
 public:
  /// Takes the frame in and returns how far it is ahead of the last: 1 = the next (or the first), more =
  /// frames were lost, 0 = repeated, which leaves the order as it was.
  std::uint32_t advance(const Frame& frame);
  bool started() const { return sequence_.has_value(); }
  TimeNs last_ns() const { return timestamp_ns_; }  ///< the least there is before the first frame

 private:
  std::optional<std::uint32_t> sequence_;
  TimeNs timestamp_ns_ = std::numeric_limits<TimeNs>::min();
};

/// The device fails, not a frame: a new try may mend it, which no try does for other UserError(device)
/// (format not offered, control not taken).
class DeviceFault : public UserError {
 public:
  enum class Kind {
    gone,       ///< unplugged: nothing more will come
    stream,     ///< the stream broke; stop() and start() may bring it back
    timeout,    ///< no frame within the time given
    no_signal,  ///< the input has no signal; frames may come all the same
  };
  DeviceFault(Kind kind, const std::string& sentence)
      : UserError(ExitCode::device, "", sentence), kind_(kind) {}
  Kind kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

struct CameraInfo {
  std::string device;  ///< as the user named it, e.g. "/dev/video0"
  int width = 0, height = 0;
  int bit_depth = 8;                ///< of Frame::dn
  std::optional<double> period_ms;  ///< between frames, where the driver says
  bool timestamp_at_exposure_start = false;
  bool triggered = false;  ///< an exposure begins when trigger() or next_frame() asks for it, not before
  std::map<std::string, std::string> provenance;  ///< driver, card, bus, format, rate, each control's value
  bool has_shared_clock = false;  ///< Frame::camera_ns is that of all cameras which say so (PTP)
  std::string pulse_line = {};    ///< whose pulses begin the exposures, "Line0"; "": none
};

/// Returns when the frame's exposure began, as far as the camera's time stamps tell.
TimeNs exposure_begin_ns(const Frame& frame, const CameraInfo& info, std::optional<double> exposure_ms);

struct ExposureRange {
  double min_ms = 0.0, max_ms = 0.0, step_ms = 0.0;
};

class CameraDevice {
 public:
  virtual ~CameraDevice() = default;

  virtual CameraInfo info() const = 0;

  /// Throws DeviceFault, or UserError(device) after several refusals.
  virtual void start() = 0;
  /// Never throws; a stopped or lost device stays so.
  virtual void stop() noexcept = 0;

  /// Begins the exposure of a triggered camera's next frame; next_frame() does it where nobody has.
  virtual void trigger() {}

  enum class Pixels { keep, drop };
  /// The next frame in order of time. `drop` leaves Frame::dn empty and costs no conversion.
  virtual Frame next_frame(std::chrono::milliseconds timeout, Pixels pixels) = 0;
  /// Drops the frames that wait already.
  virtual void drain() = 0;
  /// Throws DeviceFault(no_signal) when the input has no signal.
  virtual void check_input() = 0;

  /// nullopt: the device has no exposure control.
  virtual std::optional<ExposureRange> exposure_range() const { return std::nullopt; }
  virtual std::optional<double> exposure_ms() const { return std::nullopt; }
  /// Returns the value read back, within a step of the asked one. Throws UserError(device).
  virtual double set_exposure_ms(double exposure_ms);

  /// Now, on the clock of the time stamps.
  virtual TimeNs now_ns() const;
};

/// A device and the camera of the twin it stands for.
struct RigCamera {
  std::string name;
  int stored_bits = 8;  ///< bit_depth of the twin's sensor
  std::unique_ptr<CameraDevice> device;
};
using Rig = std::vector<RigCamera>;

}  // namespace fringetwin::capture
