// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_display.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace fringetwin::capture {
namespace {

using namespace std::chrono_literals;

constexpr double kPeriodsBeforeACopy = 3.0;
constexpr auto kLongestWait = 2000ms;

}  // namespace

V4l2Display::V4l2Display(V4l2DisplayOptions options, std::shared_ptr<V4l2Api> api)
    : options_(std::move(options)),
      device_(std::move(api), options_.device, V4L2_CAP_VIDEO_OUTPUT),
      agreed_(agree_on_output(device_, options_.format)),
      buffers_(device_, V4L2_BUF_TYPE_VIDEO_OUTPUT) {
  start();
}

// Drivers want two buffers before they stream.
void V4l2Display::start() {
  buffers_.release();
  int result = buffers_.allocate(std::max(options_.buffers, 3u));
  if (result != 0) throw device_.refusal("gives no buffers: " + error_text(result));
  queued_.assign(buffers_.size(), 0);
  picture_ = 1;
  const ImageU16 black(agreed_.layout.width, agreed_.layout.height);
  queue_one(black);
  queue_one(black);
  result = buffers_.stream_on();
  if (result != 0) throw device_.refusal("does not start to stream: " + error_text(result));
}

DisplayInfo V4l2Display::info() const {
  DisplayInfo info{.device = options_.device,
                   .width = agreed_.layout.width,
                   .height = agreed_.layout.height,
                   .bit_depth = agreed_.layout.bit_depth(),
                   .timed = is_monotonic(buffers_.flags()),
                   .provenance = device_.provenance()};
  info.provenance.insert(agreed_.provenance.begin(), agreed_.provenance.end());
  info.frame_ms = agreed_.period_ms;
  return info;
}

bool V4l2Display::any_older(std::uint64_t picture) const {
  return std::ranges::any_of(queued_, [&](std::uint64_t q) { return q != 0 && q < picture; });
}

bool V4l2Display::queue_one(const ImageU16& dn) {
  const auto mine = std::ranges::find(queued_, 0u);
  if (mine == queued_.end()) return false;
  const auto index = static_cast<unsigned>(mine - queued_.begin());
  pack_frame(dn, agreed_.layout, buffers_.bytes(index));
  if (const int result = buffers_.queue(index, agreed_.layout.used_bytes()); result != 0)
    throw_device_fault(device_, result, "queueing a picture");
  *mine = picture_;
  return true;
}

bool V4l2Display::take_back(std::chrono::milliseconds timeout) {
  v4l2_buffer buffer{};
  int result = buffers_.dequeue(buffer);
  if (result == -EAGAIN) {
    const int events = device_.poll(POLLOUT, timeout);
    if (events < 0) throw_device_fault(device_, events, "poll");
    if (events == 0) return false;
    result = buffers_.dequeue(buffer);
  }
  if (result == -EAGAIN) return false;
  if (result != 0) throw_device_fault(device_, result, "taking back a picture");
  queued_.at(buffer.index) = 0;
  const std::optional<TimeNs> stamp = stamped_ns(buffer);
  last_back_ = {stamp.value_or(steady_now_ns()), buffer.sequence, stamp.has_value()};
  return true;
}

// A device that keeps two buffers gives the older one back for a further copy only.
Shown V4l2Display::show(const Pattern& pattern, const ImageF& levels) {
  FT_CHECK(levels.width == agreed_.layout.width && levels.height == agreed_.layout.height,
           "'" + pattern.label + "' has the display's size");
  if (broken_) start();  // a broken queue comes back with new buffers
  broken_ = true;        // until this picture is on
  const ImageU16 dn = quantise_levels(levels, agreed_.layout.bit_depth());
  const auto patience = std::chrono::milliseconds(
      std::lround(std::ceil(kPeriodsBeforeACopy * agreed_.period_ms.value_or(40.0))));
  const auto deadline = std::chrono::steady_clock::now() + kLongestWait;
  ++picture_;
  bool queued = queue_one(dn);
  while (!queued || any_older(picture_)) {
    if (std::chrono::steady_clock::now() > deadline)
      throw DeviceFault(DeviceFault::Kind::stream, device_.path() + ": the picture did not come on in time");
    if (!take_back(patience) || !queued) queued = queue_one(dn) || queued;
  }
  broken_ = false;
  return last_back_;
}

}  // namespace fringetwin::capture
