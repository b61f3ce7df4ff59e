// SPDX-License-Identifier: Apache-2.0
// Turns a camera's block ids and its own clock into what a recording needs: a count without wraps, and when
// an exposure that was asked for began.
#pragma once
#include <cstdint>
#include <optional>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

/// GigE Vision counts 1 ... 65535 and begins anew with 1 (some cameras with 0); USB3 Vision and extended ids
/// count in 64 bits.
class BlockCount {
 public:
  /// Returns the number of the block in a count that never wraps; a block that comes again, or late, has a
  /// number that was there before.
  std::uint32_t number(std::uint64_t block_id);
  /// The same of a block that came with holes: where its first packet is missing, the id is one of an older
  /// block, or none, and the block is taken for the next. `trusted` says which.
  std::uint32_t number_of_damaged(std::uint64_t block_id, bool* trusted);

 private:
  std::optional<std::uint64_t> last_id_;
  std::uint32_t number_ = 0;
};

/// Tells a frame that the camera began before it was triggered (a command that was repeated on a slow network
/// makes two) from the one that was asked for, by the camera's own clock, whose offset the triggers tell: no
/// exposure begins before its trigger is sent.
class TriggerClock {
 public:
  /// Returns when the exposure began: `sent_ns`, or earlier where the camera's clock says so. `camera_ns`:
  /// the camera's stamp; 0 where it has none.
  TimeNs begin_ns(TimeNs camera_ns, TimeNs sent_ns);

 private:
  std::optional<TimeNs> least_offset_ns_;  ///< of our clock from the camera's
  TimeNs at_ns_ = 0;                       ///< when that was found
  bool doubted_ = false;                   ///< the last frame seemed too early
};

}  // namespace fringetwin::capture
