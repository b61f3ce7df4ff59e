// SPDX-License-Identifier: Apache-2.0
// Reads and sets the controls of a video device by name or number; a value counts as set when the driver
// gives it back.
#pragma once
#include <set>

#include "capture/v4l2/v4l2_device.hpp"

namespace fringetwin::capture {

struct V4l2Control {
  std::uint32_t id = 0;
  std::string name;  ///< as the driver has it: "Exposure Time, Absolute"
  std::string key;   ///< as the user writes it: "exposure_time_absolute"
  std::uint32_t type = 0;
  std::int64_t min = 0, max = 0, step = 1;
  std::uint32_t flags = 0;
  std::map<std::int64_t, std::string> items;  ///< of a menu

  bool readable() const { return (flags & V4L2_CTRL_FLAG_WRITE_ONLY) == 0 && type != V4L2_CTRL_TYPE_BUTTON; }
  bool writable() const { return (flags & V4L2_CTRL_FLAG_READ_ONLY) == 0; }
  std::string range() const;  ///< "1...10000", "0...255 in steps of 5", "0 = Off, 1 = On"
  std::string value_text(std::int64_t value) const;  ///< "250", "1 (Manual Mode)"
};

class V4l2Controls {
 public:
  explicit V4l2Controls(const V4l2Device& device);

  const std::vector<V4l2Control>& all() const { return controls_; }
  const V4l2Control* find(std::uint32_t id) const;
  /// Returns the control of this key or name, case not regarded. Throws UserError(device) that lists what
  /// there is.
  const V4l2Control& named(const std::string& name) const;

  /// Reads the present value into `value`; returns 0, or the error as a negative errno.
  int read(const V4l2Control& control, std::int64_t& value) const;
  std::int64_t get(const V4l2Control& control) const;
  /// Sets the control; throws UserError(device) unless exactly `value` is read back.
  void set(const V4l2Control& control, std::int64_t value) const;
  /// Sets a value as the user wrote it: a number, a menu's item, on or off.
  void set(const V4l2Control& control, const std::string& value) const;
  /// Throws UserError(device) when the control no longer has this value: drivers change controls that depend
  /// on each other.
  void verify(const V4l2Control& control, const std::string& value) const;
  void push(const V4l2Control& button) const;

  /// Turns off everything by which the camera changes its images on its own (automatic exposure, gain, white
  /// balance ...), but for the controls whose ids are in `kept`.
  void turn_off_automatics(const std::set<std::uint32_t>& kept) const;

  /// Returns the values of all readable controls for the record of a capture, as
  /// "control.exposure_time_absolute" -> "250".
  std::map<std::string, std::string> provenance() const;

 private:
  std::int64_t parse(const V4l2Control& control, const std::string& text) const;
  UserError refusal(const V4l2Control& control, std::int64_t value, const std::string& why) const;
  int write(const V4l2Control& control, std::int64_t value) const;

  const V4l2Device& device_;
  std::vector<V4l2Control> controls_;
};

}  // namespace fringetwin::capture
