// SPDX-License-Identifier: Apache-2.0
#include "capture/display/page_flips.hpp"

#include <fmt/format.h>

#include <cmath>

namespace fringetwin::capture {

// Drivers without vblank interrupts (virtual ones) complete a flip at once, with sequence 0.
std::string PageFlips::fault(const PageFlip& flip, std::uint32_t refreshes) const {
  if (!flip.before) return "the driver does not count refreshes";
  if (flip.sequence == 0 && flip.before->sequence == 0) return "the driver's count of refreshes stays 0";
  if (!monotonic_) return "the driver does not stamp with CLOCK_MONOTONIC";
  if (refreshes > 0x7fffffffU) return "the driver's count of refreshes went back";
  const auto elapsed_ns = static_cast<double>(flip.at_ns - flip.before->at_ns);
  // Half a period tells one refresh from the next; modes round the period by far less.
  if (std::abs(elapsed_ns - refreshes * period_ns_) > 0.5 * period_ns_)
    return fmt::format("{} refreshes in {:.2f} ms are not those of the mode ({:.2f} ms each)", refreshes,
                       elapsed_ns * 1e-6, period_ns_ * 1e-6);
  return "";
}

Shown PageFlips::add(const PageFlip& flip) {
  ++count_;
  const std::uint64_t before = flip.before ? flip.before->sequence : 0;
  const std::uint32_t refreshes = flip.sequence - static_cast<std::uint32_t>(before);  // right across a wrap
  const std::string reason = fault(flip, refreshes);
  if (!reason.empty()) {
    ++untimed_;
    why_untimed_ = reason;
    return {flip.received_ns, 0, false};
  }
  if (refreshes > 1) missed_ += refreshes - 1;
  return {flip.at_ns, before + refreshes, true};
}

}  // namespace fringetwin::capture
