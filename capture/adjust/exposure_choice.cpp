// SPDX-License-Identifier: Apache-2.0
#include "capture/adjust/exposure_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/record/streams.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::capture {
namespace {

constexpr int kMostTries = 24;
constexpr double kCloseEnough = 0.01;  // relative, of the exposure

struct Try {
  double exposure_ms = 0.0;
  double level_dn = 0.0, saturated_share = 0.0;
};

class Choice {
 public:
  Choice(const RigCamera& camera, TimeNs light_ns, const ExposureOptions& options)
      : camera_(camera), device_(*camera.device), light_ns_(light_ns), o_(options) {
    const auto range = device_.exposure_range();
    if (!range) device_.set_exposure_ms(device_.exposure_ms().value_or(1.0));  // throws: there is no control
    FT_CHECK(range.has_value(), "a device that takes exposures says which");
    range_ = *range;
    if (o_.max_ms) range_.max_ms = std::clamp(*o_.max_ms, range_.min_ms, range_.max_ms);
    full_scale_dn_ = static_cast<double>((1 << std::min(device_.info().bit_depth, camera.stored_bits)) - 1);
  }

  /// The response is linear below the clip: two exposures tell where it is reached. Where one is clipped,
  /// only that the answer is shorter.
  ExposureChoice run() {
    double low = range_.min_ms, high = range_.max_ms;
    double next = usable(std::clamp(device_.exposure_ms().value_or(std::sqrt(low * high)), low, high));
    while (tries_ < kMostTries) {
      const Try now = look(next);
      if (now.saturated_share > o_.saturated_share) {
        if (at_least(now.exposure_ms)) return result(now, ExposureChoice::Limit::least);
        high = now.exposure_ms;
      } else {
        if (at_greatest(now.exposure_ms)) return result(now, ExposureChoice::Limit::greatest);
        good_.push_back(now);
        low = now.exposure_ms;
      }
      if (!good_.empty() && high - low <= std::max(kCloseEnough * low, 1.5 * step())) break;
      next = usable(propose(low, high));
      if (!good_.empty() && next <= low) break;
    }
    if (good_.empty()) return result(look(usable(range_.min_ms)), ExposureChoice::Limit::least);
    return confirmed(low);
  }

 private:
  /// The longest of several exposures that passed may have passed by luck.
  ExposureChoice confirmed(double exposure_ms) {
    while (true) {
      const Try now = look(exposure_ms);
      if (now.saturated_share <= o_.saturated_share) return result(now, ExposureChoice::Limit::light);
      if (at_least(now.exposure_ms)) return result(now, ExposureChoice::Limit::least);
      exposure_ms =
          usable(std::max(range_.min_ms, now.exposure_ms - std::max(kCloseEnough * now.exposure_ms, step())));
    }
  }

  double step() const { return std::max(range_.step_ms, o_.unit_ms.value_or(0.0)); }
  bool at_least(double exposure_ms) const {
    return exposure_ms <= usable(range_.min_ms) + 0.5 * range_.step_ms;
  }
  bool at_greatest(double exposure_ms) const {
    return exposure_ms >= usable(range_.max_ms) - 0.5 * range_.step_ms;
  }

  /// A multiple of the projector's frame where there is one below.
  double usable(double exposure_ms) const {
    if (!o_.unit_ms || exposure_ms < *o_.unit_ms) return exposure_ms;
    return std::max(range_.min_ms, std::floor(exposure_ms / *o_.unit_ms + 1e-9) * *o_.unit_ms);
  }

  double propose(double low, double high) const {
    if (good_.empty()) return std::sqrt(std::max(low, 1e-6) * high);  // bisection, by factors
    const Try &first = good_.front(), &last = good_.back();
    const double missing_dn = full_scale_dn_ - 1.0 - last.level_dn, rise_dn = last.level_dn - first.level_dn;
    // One exposure alone: through zero, which black level and noise make too short, never too long.
    double guess = last.exposure_ms * (1.0 + missing_dn / std::max(last.level_dn, 1.0));
    if (rise_dn > 1.0)
      guess = last.exposure_ms + missing_dn * (last.exposure_ms - first.exposure_ms) / rise_dn;
    // Never less than is worth a try: the level is an integer, and noise is in it.
    guess = std::max(guess, low + std::max(kCloseEnough * low, step()));
    if (guess > high - step() && high < range_.max_ms) return 0.5 * (low + high);
    return std::min(guess, range_.max_ms);
  }

  Try look(double exposure_ms) {
    ++tries_;
    Try out{.exposure_ms = device_.set_exposure_ms(exposure_ms)};
    device_.drain();
    for (int i = 0; i < o_.settle_frames; ++i) device_.next_frame(o_.timeout, CameraDevice::Pixels::drop);
    for (int used = 0, taken = 0; used < o_.frames; ++taken) {
      throw_if_cancelled();
      if (taken > 100 + 10 * o_.frames)
        throw DeviceFault(DeviceFault::Kind::timeout,
                          fmt::format("camera \"{}\": no good frame among {}", camera_.name, taken));
      const Frame frame = device_.next_frame(o_.timeout, CameraDevice::Pixels::keep);
      if (frame.fault != FrameFault::none ||
          exposure_begin_ns(frame, device_.info(), device_.exposure_ms()) < light_ns_)
        continue;
      judge(frame.dn, &out);
      ++used;
    }
    return out;
  }

  /// The worst frame counts.
  void judge(const ImageU16& dn, Try* out) const {
    std::vector<std::uint16_t> values = dn.data;
    const auto beyond = static_cast<std::size_t>(o_.saturated_share * static_cast<double>(values.size()));
    const std::size_t last = values.size() - 1;
    out->level_dn = std::max(out->level_dn, nth_smallest(values, last - std::min(beyond, last)));
    const auto clipped = std::ranges::count_if(
        values, [&](std::uint16_t v) { return static_cast<double>(v) >= full_scale_dn_; });
    out->saturated_share =
        std::max(out->saturated_share, static_cast<double>(clipped) / static_cast<double>(values.size()));
  }

  ExposureChoice result(const Try& chosen, ExposureChoice::Limit limit) const {
    ExposureChoice out{.camera = camera_.name,
                       .exposure_ms = chosen.exposure_ms,
                       .saturated_share = chosen.saturated_share,
                       .level_dn = chosen.level_dn,
                       .full_scale_dn = full_scale_dn_,
                       .limit = limit,
                       .tries = tries_};
    return out;
  }

  const RigCamera& camera_;
  CameraDevice& device_;
  TimeNs light_ns_;
  const ExposureOptions& o_;
  ExposureRange range_;
  double full_scale_dn_ = 0.0;
  std::vector<Try> good_;  ///< exposures without too much saturation, ever longer
  int tries_ = 0;
};

}  // namespace

std::vector<ExposureChoice> choose_exposures(const Rig& rig, PatternDisplay& display,
                                             const ExposureOptions& options) {
  FT_CHECK(options.frames > 0 && options.saturated_share >= 0.0 && options.saturated_share < 1.0, "options");
  const Streams streams(rig);
  for (const RigCamera& camera : rig) camera.device->check_input();
  const Shown shown = show_even(display, 1.0, "white");
  std::vector<ExposureChoice> choices;
  for (const RigCamera& camera : rig)
    choices.push_back(Choice(camera, shown.at_ns + to_ns(options.latency_ms), options).run());
  return choices;
}

std::string ExposureChoice::text() const {
  const std::string here = fmt::format("{}: {:.4g} ms, {:.3g} % saturated, brightest {:.0f} of {:.0f} DN",
                                       camera, exposure_ms, 100.0 * saturated_share, level_dn, full_scale_dn);
  if (limit == Limit::least)
    return here + "; the least exposure is still too long: close the aperture, or dim the projector";
  if (too_dark())
    return here + "; too dark at the greatest exposure: open the aperture, raise the gain, or come closer";
  return limit == Limit::greatest ? here + "; the greatest exposure" : here;
}

}  // namespace fringetwin::capture
