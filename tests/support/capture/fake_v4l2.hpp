// SPDX-License-Identifier: Apache-2.0
// A video driver in software behind the seam of system calls: what a device offers, and what it does wrong,
// is set by the test.
#pragma once
#include <linux/videodev2.h>

#include <deque>
#include <map>
#include <set>

#include "capture/v4l2/v4l2_api.hpp"

namespace fringetwin::testing {

struct FakeControl {
  std::uint32_t id = 0;
  std::string name;
  std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
  std::int64_t min = 0, max = 1, step = 1, value = 0;
  std::map<std::int64_t, std::string> items = {};
  bool stuck = false;  ///< takes a value and keeps the old one
  std::uint32_t flags = 0;
};

struct FakeFrame {
  std::vector<std::byte> bytes;
  std::uint32_t sequence = 0;
  std::int64_t time_us = 0;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
};

class FakeV4l2 final : public capture::V4l2Api {
 public:
  // --- the device, open to the test
  std::string path = "/dev/video0";
  std::uint32_t caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_GREY};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes = {
      {8, 4}};                ///< the first when another is asked for
  std::uint32_t padding = 0;  ///< bytes behind each line
  std::uint32_t field = V4L2_FIELD_NONE;
  std::vector<double> rates_hz = {30.0};  ///< the first when another is asked for; none: no rate to set
  std::uint32_t input_status = 0;
  std::uint32_t buffer_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  std::vector<FakeControl> controls;
  std::deque<FakeFrame> frames;                     ///< yet to come; none: poll waits in vain
  std::map<unsigned long, std::deque<int>> errors;  ///< the next results of a request, 0 among them
  bool gone = false;                                ///< unplugged
  bool error_event = false;                         ///< poll() has an error and nothing else
  std::size_t held = 1;                             ///< buffers an output keeps until later ones come

  // --- what was done to it
  int opened = 0, mapped = 0;  ///< not yet closed, unmapped
  bool streaming = false;
  std::vector<std::vector<std::byte>> played;  ///< by an output, in order

  FakeControl& control(std::uint32_t id);

  std::vector<std::string> device_paths() override { return {path}; }
  int open(const std::string& which) override;
  void close(int fd) override;
  int ioctl(int fd, unsigned long request, void* argument) override;
  void* map(int fd, std::size_t length, std::uint32_t offset) override;
  void unmap(void* address, std::size_t length) override;
  int poll(int fd, short events, std::chrono::milliseconds timeout) override;

 private:
  bool is_output() const { return (caps & V4L2_CAP_VIDEO_OUTPUT) != 0; }
  int answer(unsigned long request, void* argument);
  int query_control(v4l2_query_ext_ctrl& query) const;
  int menu_item(v4l2_querymenu& item) const;
  int exchange(v4l2_ext_controls& list, bool set);
  int set_format(v4l2_format& format);
  int set_rate(v4l2_streamparm& parameters);
  int request_buffers(v4l2_requestbuffers& request);
  int queue(const v4l2_buffer& buffer);
  int dequeue(v4l2_buffer& buffer);
  int dequeue_output(v4l2_buffer& buffer);
  void stop();

  v4l2_pix_format format_{};
  v4l2_fract period_{1, 30};
  std::vector<std::vector<std::byte>> buffers_;
  std::deque<std::uint32_t> queued_;
  std::uint32_t shown_ = 0;
};

/// A UVC camera with all that changes the picture by itself turned on.
void add_camera_controls(FakeV4l2& driver);

}  // namespace fringetwin::testing
