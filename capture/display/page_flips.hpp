// SPDX-License-Identifier: Apache-2.0
// Tells from page-flip events when a pattern came on, and when they do not say it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "capture/device/pattern_display.hpp"

namespace fringetwin::capture {

/// A refresh as the driver counts and stamps it: the moment its first line goes out.
struct Refresh {
  std::uint64_t sequence = 0;
  TimeNs at_ns = 0;
};

struct PageFlip {
  std::optional<Refresh> before;  ///< the last refresh when the flip was asked for; none: not counted
  std::uint32_t sequence = 0;     ///< the event's, which wraps at 32 bits
  TimeNs at_ns = 0;               ///< the event's
  TimeNs received_ns = 0;         ///< when this program had the event
};

/// The flips of one display, in order.
class PageFlips {
 public:
  /// `monotonic`: the driver stamps with CLOCK_MONOTONIC.
  PageFlips(double period_ns, bool monotonic) : period_ns_(period_ns), monotonic_(monotonic) {}

  /// Untimed: the moment of the event's arrival, sequence 0.
  Shown add(const PageFlip& flip);

  std::uint64_t count() const { return count_; }
  std::uint64_t untimed() const { return untimed_; }
  /// Refreshes that showed the old pattern although the new one was due: a flip belongs to the refresh after
  /// the last one before it was asked for.
  std::uint64_t missed() const { return missed_; }
  /// Why the last untimed flip was so; empty if all were timed.
  const std::string& why_untimed() const { return why_untimed_; }

 private:
  std::string fault(const PageFlip& flip, std::uint32_t refreshes) const;

  double period_ns_;
  bool monotonic_;
  std::uint64_t count_ = 0, untimed_ = 0, missed_ = 0;
  std::string why_untimed_;
};

}  // namespace fringetwin::capture
