// SPDX-License-Identifier: Apache-2.0
// The system calls of a video device, so that a driver in software can stand in for the kernel's in tests.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace fringetwin::capture {

/// Errors are negative errno; EINTR is retried within.
class V4l2Api {
 public:
  virtual ~V4l2Api() = default;
  virtual std::vector<std::string> device_paths() = 0;  ///< /dev/video*, by number
  virtual int open(const std::string& path) = 0;        ///< non-blocking
  virtual void close(int fd) = 0;
  virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
  virtual void* map(int fd, std::size_t length, std::uint32_t offset) = 0;  ///< nullptr on failure
  virtual void unmap(void* address, std::size_t length) = 0;
  /// The events that happened, 0 after the timeout.
  virtual int poll(int fd, short events, std::chrono::milliseconds timeout) = 0;
};

std::shared_ptr<V4l2Api> kernel_v4l2();

}  // namespace fringetwin::capture
