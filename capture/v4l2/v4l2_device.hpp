// SPDX-License-Identifier: Apache-2.0
// An open video device and its ring of mapped buffers: what cameras and displays share.
#pragma once
#include <linux/videodev2.h>

#include <map>
#include <optional>
#include <span>

#include "capture/device/camera_device.hpp"
#include "capture/v4l2/v4l2_api.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::capture {

class V4l2Device : NotCopyable {
 public:
  /// Throws UserError(device) when it cannot be opened or is no video device of kind `needed`
  /// (V4L2_CAP_VIDEO_CAPTURE or _OUTPUT; 0: any).
  V4l2Device(std::shared_ptr<V4l2Api> api, std::string path, std::uint32_t needed);
  ~V4l2Device();

  /// 0 or negative errno.
  template <class Argument>
  int call(unsigned long request, Argument& argument) const {
    return api_->ioctl(fd_, request, &argument);
  }
  int poll(short events, std::chrono::milliseconds timeout) const { return api_->poll(fd_, events, timeout); }
  V4l2Api& api() const { return *api_; }
  int fd() const { return fd_; }
  const std::string& path() const { return path_; }

  const v4l2_capability& capability() const { return capability_; }
  std::uint32_t device_caps() const;
  /// Driver, card, bus, versions.
  std::map<std::string, std::string> provenance() const;

  UserError refusal(const std::string& what, const std::string& hint = "") const {
    return {ExitCode::device, path_, what, hint};
  }

 private:
  std::shared_ptr<V4l2Api> api_;
  std::string path_;
  int fd_ = -1;
  v4l2_capability capability_{};
};

/// "Invalid argument" of -EINVAL.
std::string error_text(int negative_errno);
/// Text in one of the kernel's fixed arrays, which need not end in a zero.
template <std::size_t size>
std::string text_of(const unsigned char (&array)[size]) {
  std::string text(reinterpret_cast<const char*>(array), size);
  return text.substr(0, text.find('\0'));
}

bool is_gone(int negative_errno);
/// Tells whether the driver stamps buffers with CLOCK_MONOTONIC.
bool is_monotonic(std::uint32_t buffer_flags);
/// nullopt: not stamped so.
std::optional<TimeNs> stamped_ns(const v4l2_buffer& buffer);
/// Throws DeviceFault: gone, or the stream with what was being done.
[[noreturn]] void throw_device_fault(const V4l2Device& device, int negative_errno, const std::string& doing);

/// Buffers of one queue, mapped; calls return 0 or negative errno.
class V4l2Buffers : NotCopyable {
 public:
  V4l2Buffers(const V4l2Device& device, v4l2_buf_type type) : device_(device), type_(type) {}
  ~V4l2Buffers() { release(); }

  int allocate(unsigned count);
  void release() noexcept;  ///< also ends the stream
  unsigned size() const { return static_cast<unsigned>(mapped_.size()); }
  std::span<std::byte> bytes(unsigned index) const { return mapped_[index]; }
  std::uint32_t flags() const { return flags_; }  ///< of a buffer before its first use: how time is stamped

  int queue(unsigned index, std::size_t used_bytes = 0);
  int dequeue(v4l2_buffer& buffer);
  int stream_on();

 private:
  int map(unsigned index);
  v4l2_buffer empty_buffer(unsigned index) const;

  const V4l2Device& device_;
  v4l2_buf_type type_;
  std::vector<std::span<std::byte>> mapped_;
  std::uint32_t flags_ = 0;
};

}  // namespace fringetwin::capture
