// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_device.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <cerrno>
#include <system_error>

namespace fringetwin::capture {
namespace {

std::string opening_hint(int error) {
  switch (-error) {
    case ENOENT:
      return "`fringetwin capture --list` names the cameras";
    case EACCES:
    case EPERM:
      return "the user must be in the group video";
    case EBUSY:
      return "another program has it";
    default:
      return "";
  }
}

std::string version_text(std::uint32_t version) {
  return fmt::format("{}.{}.{}", version >> 16 & 0xff, version >> 8 & 0xff, version & 0xff);
}

constexpr std::uint32_t kMultiplanarCaps =
    V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_VIDEO_OUTPUT_MPLANE | V4L2_CAP_VIDEO_M2M_MPLANE;

}  // namespace

std::string error_text(int negative_errno) { return std::generic_category().message(-negative_errno); }

bool is_gone(int negative_errno) { return negative_errno == -ENODEV || negative_errno == -ENXIO; }

bool is_monotonic(std::uint32_t buffer_flags) {
  return (buffer_flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
}

std::optional<TimeNs> stamped_ns(const v4l2_buffer& buffer) {
  if (!is_monotonic(buffer.flags)) return std::nullopt;
  return static_cast<TimeNs>(buffer.timestamp.tv_sec) * 1'000'000'000 +
         static_cast<TimeNs>(buffer.timestamp.tv_usec) * 1000;
}

void throw_device_fault(const V4l2Device& device, int negative_errno, const std::string& doing) {
  if (is_gone(negative_errno)) throw DeviceFault(DeviceFault::Kind::gone, device.path() + " is gone");
  throw DeviceFault(DeviceFault::Kind::stream,
                    fmt::format("{}: {} failed: {}", device.path(), doing, error_text(negative_errno)));
}

V4l2Device::V4l2Device(std::shared_ptr<V4l2Api> api, std::string path, std::uint32_t needed)
    : api_(std::move(api)), path_(std::move(path)) {
  fd_ = api_->open(path_);
  if (fd_ < 0) throw refusal("cannot be opened: " + error_text(fd_), opening_hint(fd_));
  const auto refuse = [&](const std::string& what) {
    api_->close(fd_);
    throw refusal(what, "`fringetwin capture --list` names the cameras");
  };
  if (call(VIDIOC_QUERYCAP, capability_) != 0) refuse("is no video device");
  const std::uint32_t caps = device_caps();
  const char* kind = needed == V4L2_CAP_VIDEO_OUTPUT ? "output" : "capture";
  if ((caps & needed) != needed && (caps & kMultiplanarCaps) != 0)
    refuse(fmt::format("has multi-planar formats only ({}); single-planar {} is what is supported",
                       text_of(capability_.card), kind));
  if ((caps & needed) != needed) refuse(fmt::format("{} has no video {}", text_of(capability_.card), kind));
  if (needed != 0 && (caps & V4L2_CAP_STREAMING) == 0) refuse("does not stream into mapped memory");
}

V4l2Device::~V4l2Device() { api_->close(fd_); }

std::uint32_t V4l2Device::device_caps() const {
  return (capability_.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability_.device_caps
                                                                : capability_.capabilities;
}

std::map<std::string, std::string> V4l2Device::provenance() const {
  utsname system{};
  uname(&system);
  return {{"driver", text_of(capability_.driver)},
          {"card", text_of(capability_.card)},
          {"bus", text_of(capability_.bus_info)},
          {"driver_version", version_text(capability_.version)},
          {"kernel", system.release}};
}

v4l2_buffer V4l2Buffers::empty_buffer(unsigned index) const {
  v4l2_buffer buffer{};
  buffer.type = type_;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

int V4l2Buffers::allocate(unsigned count) {
  release();
  v4l2_requestbuffers request{};
  request.count = count;
  request.type = type_;
  request.memory = V4L2_MEMORY_MMAP;
  int result = device_.call(VIDIOC_REQBUFS, request);
  if (result == 0 && request.count < 2) result = -ENOMEM;
  for (unsigned i = 0; result == 0 && i < request.count; ++i) result = map(i);
  if (result != 0) release();
  return result;
}

int V4l2Buffers::map(unsigned index) {
  v4l2_buffer buffer = empty_buffer(index);
  if (const int result = device_.call(VIDIOC_QUERYBUF, buffer); result != 0) return result;
  void* address = device_.api().map(device_.fd(), buffer.length, buffer.m.offset);
  if (address == nullptr) return -ENOMEM;
  mapped_.emplace_back(static_cast<std::byte*>(address), buffer.length);
  flags_ = buffer.flags;
  return 0;
}

// Mapped buffers would keep the driver's memory, and REQBUFS(0) failing (an unplugged device) changes
// nothing.
void V4l2Buffers::release() noexcept {
  int type = static_cast<int>(type_);
  device_.call(VIDIOC_STREAMOFF, type);
  for (const std::span<std::byte> buffer : mapped_) device_.api().unmap(buffer.data(), buffer.size());
  mapped_.clear();
  v4l2_requestbuffers none{};
  none.type = type_;
  none.memory = V4L2_MEMORY_MMAP;
  device_.call(VIDIOC_REQBUFS, none);
}

int V4l2Buffers::queue(unsigned index, std::size_t used_bytes) {
  v4l2_buffer buffer = empty_buffer(index);
  buffer.bytesused = static_cast<std::uint32_t>(used_bytes);
  buffer.field = V4L2_FIELD_NONE;
  return device_.call(VIDIOC_QBUF, buffer);
}

int V4l2Buffers::dequeue(v4l2_buffer& buffer) {
  buffer = empty_buffer(0);
  return device_.call(VIDIOC_DQBUF, buffer);
}

int V4l2Buffers::stream_on() {
  int type = static_cast<int>(type_);
  return device_.call(VIDIOC_STREAMON, type);
}

}  // namespace fringetwin::capture
