// SPDX-License-Identifier: Apache-2.0
// The border between the program and its module that knows Aravis: GenICam cameras (USB3 Vision, GigE Vision)
// with their features by name, and the buffers that they send. A fake stands in for
// it where no camera is needed (tests/support/capture/fake_genicam.hpp).
#pragma once
#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

struct GenicamListed {
  std::string id;  ///< for GenicamModule::open
  std::string vendor, model, serial;
  std::string protocol;  ///< "GigEVision", "USB3Vision"
  std::string address;   ///< of the network; "" = none
};

/// A feature as it is now. What does not apply is empty or 0.
struct GenicamFeature {
  enum class Kind { missing, integer, number, boolean, choice, command, text };
  Kind kind = Kind::missing;
  bool readable = false, writable = false;
  std::string value;  ///< as text: "12.5", "true", "Mono8"
  double min = 0.0, max = 0.0;
  double step = 0.0;  ///< 0: any value
  std::string unit;
  std::vector<std::string> choices;  ///< that can be set now

  bool there() const { return kind != Kind::missing; }
  bool is_number() const { return kind == Kind::integer || kind == Kind::number; }
  bool has_choice(const std::string& choice) const {
    return std::ranges::find(choices, choice) != choices.end();
  }
};

/// What the camera sent for one frame; its bytes are the module's until the next call of next() or
/// stream_off().
struct GenicamBuffer {
  enum class State {
    whole,
    incomplete,    ///< packets are missing
    wrong_length,  ///< more than the buffer holds
    aborted
  };
  State state = State::whole;
  int status = 0;              ///< Aravis' own number of it, for the record
  std::uint64_t block_id = 0;  ///< the camera's count: 1 ... 65535 and again from 1, or 64 bits
  TimeNs camera_ns = 0;        ///< on the camera's own clock; 0: it gives none
  TimeNs came_ns = 0;          ///< its first packet, on the program's clock
  std::uint32_t pixel_format = 0;
  int width = 0, height = 0;
  int line_padding = 0;  ///< bytes
  std::span<const std::byte> bytes;
};

/// Counts since the stream was begun.
struct GenicamCounts {
  std::uint64_t underruns = 0;  ///< frames for which no buffer was free
  std::uint64_t missing_packets = 0, resend_requests = 0, resent_packets = 0;
};

/// Nothing of it throws; `fault` says why something was not done.
class GenicamDevice {
 public:
  virtual ~GenicamDevice() = default;

  /// Returns whether this program may change the camera: another one may hold it.
  virtual bool controlled() const = 0;
  /// Returns whether control was lost since: no answer, or another program took it.
  virtual bool lost() const = 0;
  /// Asks the camera something.
  virtual bool answers() = 0;

  virtual std::vector<std::string> feature_names() = 0;
  virtual GenicamFeature feature(const std::string& name) = 0;
  virtual bool set(const std::string& name, const std::string& value, std::string* fault) = 0;
  virtual bool execute(const std::string& command, std::string* fault) = 0;

  /// Makes so many buffers of the camera's payload and receives; acquisition is begun by a command.
  virtual bool stream_on(unsigned buffers, std::string* fault) = 0;
  virtual void stream_off() noexcept = 0;
  /// Returns the next buffer in order, faulty ones too; nullopt when none comes in time.
  virtual std::optional<GenicamBuffer> next(std::chrono::milliseconds timeout) = 0;
  virtual GenicamCounts counts() = 0;
};

/// The module's only object. Nothing of it throws.
class GenicamModule {
 public:
  virtual ~GenicamModule() = default;
  virtual std::string version() const = 0;           ///< "Aravis 0.8.26"
  virtual std::vector<GenicamListed> devices() = 0;  ///< asks all networks, for about a second
  virtual std::unique_ptr<GenicamDevice> open(const std::string& id, std::string* fault) = 0;
};

/// The module's only function, by this name.
using GenicamModuleFunction = GenicamModule* (*)();
constexpr const char* kGenicamModuleName =
    "fringetwin_genicam_module_1";  ///< 1: the classes as they stand here

/// Throws UserError(device), which says what to install, when the module or Aravis is not found.
GenicamModule& genicam_module();

}  // namespace fringetwin::capture
