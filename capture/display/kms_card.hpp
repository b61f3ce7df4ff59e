// SPDX-License-Identifier: Apache-2.0
// A graphics card through libdrm: its connectors, the right to set modes, frame buffers, page-flip events.
#pragma once
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "capture/device/pattern_display.hpp"
#include "capture/display/kms_modes.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::capture {

template <auto Function>
struct FreedBy {
  template <class T>
  void operator()(T* pointer) const {
    Function(pointer);
  }
};
using DrmResources = std::unique_ptr<drmModeRes, FreedBy<drmModeFreeResources>>;
using DrmConnector = std::unique_ptr<drmModeConnector, FreedBy<drmModeFreeConnector>>;
using DrmEncoder = std::unique_ptr<drmModeEncoder, FreedBy<drmModeFreeEncoder>>;
using DrmCrtc = std::unique_ptr<drmModeCrtc, FreedBy<drmModeFreeCrtc>>;

/// /dev/dri/card0, ...
std::vector<std::string> kms_cards();

/// Returns the fault that an error number of the kernel means while patterns are shown.
DeviceFault kms_fault(int error, const std::string& where, const std::string& doing);

/// Exact, from the mode's clock and totals.
double mode_period_ns(const drmModeModeInfo& mode);

/// A connector with what choose_connector and choose_mode need; modes[i] belongs to facts.modes[i].
struct KmsHead {
  std::uint32_t connector = 0;
  KmsConnector facts;
  std::vector<drmModeModeInfo> modes;
};

/// An event of the kernel, as it came.
struct FlipDone {
  std::uint32_t sequence = 0;
  TimeNs at_ns = 0, received_ns = 0;
};

/// An open graphics card. One thread at a time may use it.
class KmsCard : NotCopyable {
 public:
  /// One object per card and program: displays on two connectors share it. Throws UserError(device).
  static std::shared_ptr<KmsCard> open(const std::string& path);
  ~KmsCard();

  int fd() const { return fd_; }
  const std::string& path() const { return path_; }
  std::string driver() const;  ///< name, version and date
  bool monotonic() const;      ///< time stamps are of CLOCK_MONOTONIC
  std::vector<KmsHead> heads() const;

  /// Throws UserError(device) when another program has the right to set modes.
  void become_master();
  /// A CRTC for the connector, the one it has if possible, and none of another connector if possible. Throws
  /// UserError(device).
  std::uint32_t take_crtc(std::uint32_t connector);
  void give_crtc_back(std::uint32_t crtc) noexcept { taken_crtcs_.erase(crtc); }

  /// Asks for the buffer from the next refresh on; the answer is what wait() wants. Throws DeviceFault.
  std::uint64_t flip(std::uint32_t crtc, std::uint32_t buffer);
  /// Throws DeviceFault(timeout), DeviceFault(gone).
  FlipDone wait(std::uint64_t flip, std::chrono::milliseconds timeout);

 private:
  explicit KmsCard(const std::string& path);
  void read_events(std::chrono::milliseconds timeout);
  static void on_flip(int fd, unsigned sequence, unsigned s, unsigned us, unsigned crtc, void* done);

  std::string path_;
  int fd_ = -1;
  std::set<std::uint32_t> taken_crtcs_;
  std::uint64_t last_flip_ = 0;
  std::map<std::uint64_t, std::optional<FlipDone>> flips_;  ///< asked for, at addresses the kernel knows
};

/// A frame buffer of 8 bits per channel in memory, gray.
class KmsBuffer : NotCopyable {
 public:
  /// Black. Throws UserError(device).
  KmsBuffer(std::shared_ptr<KmsCard> card, int width, int height);
  ~KmsBuffer();

  void write(const ImageU16& gray);
  std::uint32_t id() const { return id_; }

 private:
  std::shared_ptr<KmsCard> card_;
  drm_mode_create_dumb dumb_{};
  std::uint32_t id_ = 0;
  void* memory_ = nullptr;
};

}  // namespace fringetwin::capture
