// SPDX-License-Identifier: Apache-2.0
#include "capture/genicam/frame_count.hpp"

namespace fringetwin::capture {
namespace {

constexpr std::uint64_t kLargestShortId = 65535;
constexpr double kDrift = 2e-4;  ///< two crystals of 100 ppm
/// Below any exposure's distance from the one before, above the scatter of a command's way to the camera.
constexpr TimeNs kTooEarlyNs = 1'000'000;

/// Returns how many blocks lie between two ids, signed.
std::int64_t distance(std::uint64_t from, std::uint64_t to) {
  const auto ahead = static_cast<std::int64_t>(to - from);
  if (ahead >= 0 || from > kLargestShortId) return ahead;
  const std::int64_t wrapped = ahead + static_cast<std::int64_t>(kLargestShortId) + (to == 0 ? 1 : 0);
  return wrapped <= static_cast<std::int64_t>(kLargestShortId) / 2 ? wrapped : ahead;
}

}  // namespace

std::uint32_t BlockCount::number(std::uint64_t block_id) {
  if (!last_id_) {
    last_id_ = block_id;
    return number_ = static_cast<std::uint32_t>(block_id);
  }
  const std::int64_t ahead = distance(*last_id_, block_id);
  const auto number = static_cast<std::uint32_t>(static_cast<std::int64_t>(number_) + ahead);
  if (ahead <= 0) return number;
  last_id_ = block_id;
  return number_ = number;
}

std::uint32_t BlockCount::number_of_damaged(std::uint64_t block_id, bool* trusted) {
  constexpr std::int64_t kMostLost = 1000;  // at a time
  const std::int64_t ahead = last_id_ ? distance(*last_id_, block_id) : 0;
  *trusted = block_id != 0 && ahead >= 1 && ahead <= kMostLost;
  if (*trusted) return number(block_id);
  if (!last_id_) return 0;  // before all others
  last_id_ = *last_id_ == kLargestShortId ? 1 : *last_id_ + 1;
  return ++number_;
}

TimeNs TriggerClock::begin_ns(TimeNs camera_ns, TimeNs sent_ns) {
  if (camera_ns == 0) return sent_ns;
  const TimeNs offset_ns = sent_ns - camera_ns;
  if (!least_offset_ns_) {
    least_offset_ns_ = offset_ns;
    at_ns_ = sent_ns;
    return sent_ns;
  }
  const auto drift_ns = static_cast<TimeNs>(kDrift * static_cast<double>(sent_ns - at_ns_));
  const TimeNs known_ns = *least_offset_ns_;
  const bool too_early = offset_ns > known_ns + drift_ns + kTooEarlyNs;
  // Twice running it is the offset that was not known well: the commands before were slow.
  if (too_early && !doubted_) {
    doubted_ = true;
    return camera_ns + known_ns;
  }
  doubted_ = false;
  least_offset_ns_ = std::max(offset_ns, known_ns - drift_ns);
  at_ns_ = sent_ns;
  return sent_ns;
}

}  // namespace fringetwin::capture
