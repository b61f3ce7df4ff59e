// SPDX-License-Identifier: Apache-2.0
// A GigE Vision camera in software that sends real packets over the loopback (Aravis' own), with pixel
// formats that Aravis' lacks and images of the test's choice. One test program at a time: its port is fixed.
// For *_test.cpp only.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "capture/device/camera_device.hpp"

namespace fringetwin::testing {

/// Returns the address of a network interface besides the loopback; "" where there is none.
std::string other_interface_address();

/// What one frame is asked for.
struct GigeFrame {
  std::uint64_t block_id = 0;
  int width = 0, height = 0, bit_depth = 8;
};

class FakeGige {
 public:
  using Picture = std::function<capture::ImageU16(const GigeFrame&)>;

  /// `address`: of a network interface of this machine; each camera needs one of its own.
  explicit FakeGige(std::string serial = "T01", std::string address = "127.0.0.1");
  ~FakeGige();
  FakeGige(const FakeGige&) = delete;
  FakeGige& operator=(const FakeGige&) = delete;

  bool running() const;
  /// The share of packets that are not sent.
  void lose(double share);
  /// Makes the pictures from now on; they are noise, another for each block, until then.
  void show(Picture picture);
  /// Sends the next frames with so long between two.
  void set_period_us(unsigned period_us);
  /// Returns whether the camera acquires and waits for pulses on Line0.
  bool awaits_pulse() const;
  /// Sends one, of which the camera makes a frame with this time of its clock; returns false when it makes
  /// none.
  bool pulse(capture::TimeNs camera_ns);
  /// Switches the camera off, without a word.
  void kill();
  /// Switches it on again, with nothing set.
  void revive();

  /// Returns the picture that was sent as this block; empty if none was.
  capture::ImageU16 sent(std::uint64_t block_id) const;
  std::size_t n_sent() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace fringetwin::testing
