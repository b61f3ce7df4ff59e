// SPDX-License-Identifier: Apache-2.0
#include "tests/support/capture/fake_v4l2.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "capture/device/pixel_format.hpp"

namespace fringetwin::testing {
namespace {

template <std::size_t size>
void write_text(unsigned char (&to)[size], const char* text) {
  std::strncpy(reinterpret_cast<char*>(to), text, size - 1);
}

constexpr std::uint32_t page = 4096;
constexpr int descriptor = 7;

}  // namespace

FakeControl& FakeV4l2::control(std::uint32_t id) {
  return *std::find_if(controls.begin(), controls.end(), [&](const FakeControl& c) { return c.id == id; });
}

int FakeV4l2::open(const std::string& which) {
  if (which != path) return -ENOENT;
  if (gone) return -ENODEV;
  ++opened;
  return descriptor;
}

void FakeV4l2::close(int fd) { opened -= fd == descriptor; }

int FakeV4l2::ioctl(int fd, unsigned long request, void* argument) {
  if (fd != descriptor) return -EBADF;
  if (gone) return -ENODEV;
  if (std::deque<int>& results = errors[request]; !results.empty()) {
    const int result = results.front();
    results.pop_front();
    if (result != 0) return result;
  }
  return answer(request, argument);
}

int FakeV4l2::answer(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      write_text(capability.driver, "fake");
      write_text(capability.card, "Fake camera");
      write_text(capability.bus_info, "usb-1");
      capability.version = 6 << 16 | 1 << 8 | 9;
      capability.capabilities = caps | V4L2_CAP_DEVICE_CAPS;
      capability.device_caps = caps;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& entry = *static_cast<v4l2_fmtdesc*>(argument);
      if (entry.index >= formats.size()) return -EINVAL;
      entry.pixelformat = formats[entry.index];
      return 0;
    }
    case VIDIOC_ENUM_FRAMESIZES: {
      auto& entry = *static_cast<v4l2_frmsizeenum*>(argument);
      if (entry.index >= sizes.size()) return -EINVAL;
      entry.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      entry.discrete = {sizes[entry.index].first, sizes[entry.index].second};
      return 0;
    }
    case VIDIOC_G_FMT: {
      auto& format = *static_cast<v4l2_format*>(argument);
      format.fmt.pix.width = sizes[0].first;
      format.fmt.pix.height = sizes[0].second;
      return set_format(format);
    }
    case VIDIOC_S_FMT:
      return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& parameters = *static_cast<v4l2_streamparm*>(argument);
      return request == VIDIOC_S_PARM
                 ? set_rate(parameters)
                 : (parameters.parm.capture.timeperframe = period_,
                    parameters.parm.capture.capability =
                        rates_hz.empty() ? 0u : static_cast<std::uint32_t>(V4L2_CAP_TIMEPERFRAME),
                    0);
    }
    case VIDIOC_G_INPUT:
      return is_output() ? -ENOTTY : (*static_cast<std::uint32_t*>(argument) = 0, 0);
    case VIDIOC_ENUMINPUT: {
      auto& input = *static_cast<v4l2_input*>(argument);
      write_text(input.name, "Sensor");
      input.status = input_status;
      return 0;
    }
    case VIDIOC_QUERY_EXT_CTRL:
      return query_control(*static_cast<v4l2_query_ext_ctrl*>(argument));
    case VIDIOC_QUERYMENU:
      return menu_item(*static_cast<v4l2_querymenu*>(argument));
    case VIDIOC_G_EXT_CTRLS:
    case VIDIOC_S_EXT_CTRLS:
      return exchange(*static_cast<v4l2_ext_controls*>(argument), request == VIDIOC_S_EXT_CTRLS);
    case VIDIOC_REQBUFS:
      return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = static_cast<std::uint32_t>(buffers_.at(buffer.index).size());
      buffer.m.offset = buffer.index * page;
      buffer.flags = buffer_flags;
      return 0;
    }
    case VIDIOC_QBUF:
      return queue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return dequeue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      streaming = true;
      return 0;
    case VIDIOC_STREAMOFF:
      stop();
      return 0;
    default:
      return -ENOTTY;
  }
}

// --- controls

int FakeV4l2::query_control(v4l2_query_ext_ctrl& query) const {
  const std::uint32_t after = query.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
  const FakeControl* next = nullptr;  // the least number above
  for (const FakeControl& c : controls)
    if (c.id > after && (next == nullptr || c.id < next->id)) next = &c;
  if (next == nullptr) return -EINVAL;
  query.id = next->id;
  query.type = next->type;
  std::strncpy(query.name, next->name.c_str(), sizeof query.name - 1);
  query.minimum = next->min;
  query.maximum = next->max;
  query.step = static_cast<std::uint64_t>(next->step);
  query.flags = next->flags;
  query.nr_of_dims = 0;
  return 0;
}

int FakeV4l2::menu_item(v4l2_querymenu& item) const {
  for (const FakeControl& c : controls)
    if (c.id == item.id && c.items.contains(item.index)) {
      std::strncpy(reinterpret_cast<char*>(item.name), c.items.at(item.index).c_str(), sizeof item.name - 1);
      return 0;
    }
  return -EINVAL;
}

int FakeV4l2::exchange(v4l2_ext_controls& list, bool set) {
  for (std::uint32_t i = 0; i < list.count; ++i) {
    v4l2_ext_control& one = list.controls[i];
    const auto found =
        std::find_if(controls.begin(), controls.end(), [&](const FakeControl& c) { return c.id == one.id; });
    if (found == controls.end()) return -EINVAL;
    const bool wide = found->type == V4L2_CTRL_TYPE_INTEGER64;
    if (set && !found->stuck)
      found->value =
          std::clamp(wide ? static_cast<std::int64_t>(one.value64) : one.value, found->min, found->max);
    if (!set && wide) one.value64 = found->value;
    if (!set && !wide) one.value = static_cast<std::int32_t>(found->value);
  }
  return 0;
}

// --- format

int FakeV4l2::set_format(v4l2_format& format) {
  v4l2_pix_format& pix = format.fmt.pix;
  const std::pair<std::uint32_t, std::uint32_t> asked{pix.width, pix.height};
  const auto [width, height] =
      std::find(sizes.begin(), sizes.end(), asked) != sizes.end() ? asked : sizes.front();
  if (std::find(formats.begin(), formats.end(), pix.pixelformat) == formats.end())
    pix.pixelformat = formats.front();
  pix.width = width;
  pix.height = height;
  pix.field = field;
  const auto known = capture::pixel_format_of_fourcc(pix.pixelformat);
  const int bytes = known ? capture::traits(*known).bytes_per_pixel : 3;
  pix.bytesperline = bytes == 0 ? 0 : width * static_cast<std::uint32_t>(bytes) + padding;
  pix.sizeimage = bytes == 0 ? width * height * 4 + 2048 : pix.bytesperline * height;
  format_ = pix;
  return 0;
}

int FakeV4l2::set_rate(v4l2_streamparm& parameters) {
  v4l2_fract& period = parameters.parm.capture.timeperframe;
  const double asked = static_cast<double>(period.denominator) / period.numerator;
  const auto same = [&](double rate) { return std::abs(rate - asked) < 1e-6; };
  const double rate = std::any_of(rates_hz.begin(), rates_hz.end(), same) ? asked : rates_hz.front();
  period = period_ = {1000, static_cast<std::uint32_t>(std::lround(rate * 1000.0))};
  return 0;
}

// --- buffers

int FakeV4l2::request_buffers(v4l2_requestbuffers& request) {
  if (mapped > 0) return -EBUSY;
  stop();
  buffers_.assign(request.count, std::vector<std::byte>(format_.sizeimage));
  return 0;
}

void* FakeV4l2::map(int, std::size_t length, std::uint32_t offset) {
  std::vector<std::byte>& buffer = buffers_.at(offset / page);
  if (buffer.size() != length) return nullptr;
  ++mapped;
  return buffer.data();
}

void FakeV4l2::unmap(void*, std::size_t) { --mapped; }

int FakeV4l2::queue(const v4l2_buffer& buffer) {
  if (buffer.index >= buffers_.size()) return -EINVAL;
  if (std::find(queued_.begin(), queued_.end(), buffer.index) != queued_.end()) return -EINVAL;
  queued_.push_back(buffer.index);
  if (is_output()) {
    const std::vector<std::byte>& bytes = buffers_[buffer.index];
    played.emplace_back(bytes.begin(), bytes.begin() + buffer.bytesused);
  }
  return 0;
}

int FakeV4l2::dequeue(v4l2_buffer& buffer) {
  if (!streaming) return -EINVAL;
  if (is_output()) return dequeue_output(buffer);
  if (frames.empty() || queued_.empty()) return -EAGAIN;
  const FakeFrame frame = std::move(frames.front());
  frames.pop_front();
  buffer.index = queued_.front();
  queued_.pop_front();
  std::vector<std::byte>& to = buffers_[buffer.index];
  std::copy_n(frame.bytes.begin(), std::min(frame.bytes.size(), to.size()), to.begin());
  buffer.bytesused = static_cast<std::uint32_t>(frame.bytes.size());
  buffer.sequence = frame.sequence;
  buffer.flags = frame.flags;
  buffer.timestamp = {frame.time_us / 1'000'000, frame.time_us % 1'000'000};
  return 0;
}

int FakeV4l2::dequeue_output(v4l2_buffer& buffer) {
  if (queued_.size() <= held) return -EAGAIN;
  buffer.index = queued_.front();
  queued_.pop_front();
  buffer.sequence = shown_++;
  buffer.flags = buffer_flags;
  buffer.timestamp = {0, 1000 * static_cast<long>(shown_)};
  return 0;
}

void FakeV4l2::stop() {
  streaming = false;
  queued_.clear();
}

int FakeV4l2::poll(int, short events, std::chrono::milliseconds) {
  if (gone) return POLLERR | POLLHUP;
  if (error_event) return POLLERR;
  const bool error = !errors[VIDIOC_DQBUF].empty();
  const bool ready = is_output() ? queued_.size() > held : !frames.empty();
  return ready || error ? events : 0;
}

void add_camera_controls(FakeV4l2& driver) {
  driver.controls.insert(
      driver.controls.end(),
      {{V4L2_CID_EXPOSURE_AUTO,
        "Auto Exposure",
        V4L2_CTRL_TYPE_MENU,
        0,
        3,
        1,
        3,
        {{1, "Manual Mode"}, {3, "Aperture Priority Mode"}}},
       {V4L2_CID_EXPOSURE_ABSOLUTE, "Exposure Time, Absolute", V4L2_CTRL_TYPE_INTEGER, 10, 10000, 10, 150},
       {V4L2_CID_EXPOSURE_AUTO_PRIORITY, "Exposure, Dynamic Framerate", V4L2_CTRL_TYPE_BOOLEAN, 0, 1, 1, 1},
       {V4L2_CID_AUTO_WHITE_BALANCE, "White Balance, Automatic", V4L2_CTRL_TYPE_BOOLEAN, 0, 1, 1, 1},
       {V4L2_CID_AUTOGAIN, "Gain, Automatic", V4L2_CTRL_TYPE_BOOLEAN, 0, 1, 1, 1},
       {V4L2_CID_GAIN, "Gain", V4L2_CTRL_TYPE_INTEGER, 0, 255, 1, 16},
       {V4L2_CID_BACKLIGHT_COMPENSATION, "Backlight Compensation", V4L2_CTRL_TYPE_INTEGER, 0, 4, 1, 2},
       {V4L2_CID_FOCUS_AUTO, "Focus, Automatic Continuous", V4L2_CTRL_TYPE_BOOLEAN, 0, 1, 1, 1}});
}

}  // namespace fringetwin::testing
