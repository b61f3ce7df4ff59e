// SPDX-License-Identifier: Apache-2.0
#include "capture/adjust/latency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <thread>

#include "capture/adjust/light_levels.hpp"
#include "capture/record/streams.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::capture {
namespace {

constexpr int kReferenceFrames = 16;
constexpr double kLeastMarginMs = 0.5;
constexpr int kLongestExtraRun = 8;  ///< frames
constexpr int kPatientChanges = 2;   ///< with long runs, until the latency is roughly known

double ms(TimeNs ns) { return static_cast<double>(ns) / kNsPerMs; }

Spread spread(std::vector<double> values) {
  const double least = *std::ranges::min_element(values);
  const double most = *std::ranges::max_element(values);
  return {least, median(values), most};
}

/// A frame after a change, by the light in it.
struct Seen {
  TimeNs begin_ns = 0;
  double least = 0.0, most = 0.0;  ///< share of the new light, over the parts of the image
  bool follows = true;             ///< no frame was lost before it
};

/// One change, seen by one camera.
struct Change {
  double begins_ms = 0.0, complete_ms = 0.0;
  double incomplete_ms = 0.0;  ///< the last frame with old light
  int begins_frame = 0, complete_frame = 0, mixed = 0;
};

/// The first of the frames is the last one before the change. nullopt: a frame is missing where it matters,
/// or the new light was not there at the end.
std::optional<Change> read_change(const std::vector<Seen>& frames, TimeNs shown_ns, double threshold) {
  // Two in a row: a single share beyond the threshold is noise, seen once in some thousand.
  const auto stays = [&](std::size_t i, auto test) {
    return test(frames[i]) && (i + 1 == frames.size() || test(frames[i + 1]));
  };
  const auto is_new = [&](const Seen& frame) { return frame.least >= 1.0 - threshold; };
  const auto has_new = [&](const Seen& frame) { return frame.most > threshold; };
  std::size_t begins = 0, complete = 0;
  while (complete < frames.size() && !stays(complete, is_new)) ++complete;
  if (complete == frames.size() || complete == 0) return {};
  while (!stays(begins, has_new)) ++begins;
  for (std::size_t i = begins; i <= complete; ++i)
    if (!frames[i].follows) return {};
  int before = 0;
  for (const Seen& frame : frames) before += frame.begin_ns < shown_ns;
  Change change{.begins_ms = ms(frames[begins].begin_ns - shown_ns),
                .complete_ms = ms(frames[complete].begin_ns - shown_ns),
                .incomplete_ms = ms(frames[complete - 1].begin_ns - shown_ns),
                .begins_frame = static_cast<int>(begins) - before + 1,
                .complete_frame = static_cast<int>(complete) - before + 1,
                .mixed = static_cast<int>(complete - begins)};
  return change;
}

class Calibration {
 public:
  Calibration(const Rig& rig, PatternDisplay& display, const LatencyOptions& options)
      : rig_(rig), display_(display), options_(options), streams_(rig), random_(options.seed) {}

  Latency run() {
    learn_levels();
    changes_.resize(rig_.size());
    Progress progress("latency", static_cast<std::size_t>(options_.changes));
    for (int i = 0; i < options_.changes; ++i) {
      watch_change(i % 2 == 0 ? 0.0 : 1.0);  // white is on when the levels are known
      progress.advance();
    }
    Latency latency;
    for (std::size_t c = 0; c < rig_.size(); ++c) latency.cameras.push_back(summarise(c));
    recommend(&latency);
    return latency;
  }

 private:
  struct Watch {
    FrameOrder order;
    TimeNs last_begin_ns = 0;
    bool broken = false;  ///< a frame was lost or faulty since the last good one
  };

  TimeNs begin_ns(std::size_t camera, const Frame& frame) const {
    const CameraDevice& device = *rig_[camera].device;
    return exposure_begin_ns(frame, device.info(), device.exposure_ms());
  }

  /// The camera's next new frame without fault.
  Frame next(std::size_t camera, CameraDevice::Pixels pixels = CameraDevice::Pixels::keep) {
    Watch& watch = watches_[camera];
    while (true) {
      throw_if_cancelled();
      Frame frame = rig_[camera].device->next_frame(options_.timeout, pixels);
      const bool first = !watch.order.started();
      const TimeNs before_ns = watch.order.last_ns();
      const std::uint32_t ahead = watch.order.advance(frame);
      if (ahead == 0) continue;  // repeated
      if (!first && ahead == 1) period_ns_ = std::min(period_ns_, frame.timestamp_ns - before_ns);
      watch.broken = watch.broken || ahead != 1 || frame.fault != FrameFault::none;
      watch.last_begin_ns = begin_ns(camera, frame);
      if (frame.fault == FrameFault::none) return frame;
    }
  }

  std::vector<std::vector<ImageU16>> references(double level, const char* label) {
    const Shown shown = show_even(display_, level, label);
    const TimeNs from_ns = shown.at_ns + to_ns(options_.patience_ms);
    std::vector<std::vector<ImageU16>> frames(rig_.size());
    bool all = false;
    while (!all) {
      all = true;
      for (std::size_t c = 0; c < rig_.size(); ++c) {
        if (frames[c].size() == kReferenceFrames) continue;
        all = false;
        const bool far = watches_[c].last_begin_ns + 2 * period_ns_ < from_ns;
        Frame frame = next(c, far ? CameraDevice::Pixels::drop : CameraDevice::Pixels::keep);
        if (!far && begin_ns(c, frame) >= from_ns) frames[c].push_back(std::move(frame.dn));
      }
    }
    return frames;
  }

  void learn_levels() {
    watches_.resize(rig_.size());
    const auto black = references(0.0, "black"), white = references(1.0, "white");
    for (std::size_t c = 0; c < rig_.size(); ++c)
      levels_.emplace_back(rig_[c].name, black[c], white[c],
                           std::min(rig_[c].device->info().bit_depth, rig_[c].stored_bits));
  }

  /// Long enough for the slowest change so far, and a random part.
  TimeNs run_ns() {
    if (n_seen_ < kPatientChanges) return to_ns(options_.patience_ms);
    std::uniform_real_distribution<double> extra(3.0, 3.0 + kLongestExtraRun);
    return static_cast<TimeNs>(1.5 * static_cast<double>(slowest_ns_) +
                               extra(random_) * static_cast<double>(period_ns_));
  }

  /// A change right behind a frame's end would always meet the next frames in the same phase.
  void wait_a_part_of_a_frame() {
    if (std::abs(rig_.front().device->now_ns() - steady_now_ns()) > to_ns(1.0)) return;  // a clock of its own
    std::uniform_real_distribution<double> part(0.0, static_cast<double>(period_ns_));
    std::this_thread::sleep_for(std::chrono::nanoseconds(static_cast<TimeNs>(part(random_))));
  }

  void watch_change(double level) {
    wait_a_part_of_a_frame();
    const Shown shown = show_even(display_, level, level > 0.0 ? "white" : "black");
    const TimeNs until_ns = shown.at_ns + run_ns();
    std::vector<std::vector<Seen>> seen;
    for (const Watch& watch : watches_)
      seen.push_back({{watch.last_begin_ns, 0.0, 0.0, true}});  // the level before
    bool all = false;
    while (!all) {
      all = true;
      for (std::size_t c = 0; c < rig_.size(); ++c) {
        if (seen[c].back().begin_ns >= until_ns) continue;
        all = false;
        const Frame frame = next(c);
        std::vector<double> shares = levels_[c].shares(frame.dn);
        if (level == 0.0)
          for (double& share : shares) share = 1.0 - share;
        const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
        seen[c].push_back({begin_ns(c, frame), *least, *most, !watches_[c].broken});
        watches_[c].broken = false;
      }
    }
    bool whole = true;
    for (std::size_t c = 0; c < rig_.size(); ++c) {
      const auto change = read_change(seen[c], shown.at_ns, levels_[c].threshold());
      whole = whole && change;
      if (!change) continue;
      changes_[c].push_back(*change);
      slowest_ns_ = std::max(slowest_ns_, to_ns(change->complete_ms));
    }
    n_seen_ = whole ? n_seen_ + 1 : 0;  // patience again: the next run begins from a light that stands
  }

  /// Returns by how much too early a frame may be taken for complete.
  double unseen_ms(const CameraLatency& camera) const { return camera.threshold * ms(period_ns_); }

  CameraLatency summarise(std::size_t c) const {
    const std::vector<Change>& changes = changes_[c];
    CameraLatency out;
    out.camera = rig_[c].name;
    out.changes = static_cast<int>(changes.size());
    out.discarded = options_.changes - out.changes;
    if (2 * out.changes < options_.changes)
      throw UserError(ExitCode::device, fmt::format("camera \"{}\"", out.camera),
                      fmt::format("saw only {} of {} changes between black and white whole", out.changes,
                                  options_.changes),
                      "frames are lost, or the light needs longer than a second");
    out.black_dn = levels_[c].black_dn();
    out.white_dn = levels_[c].white_dn();
    out.threshold = levels_[c].threshold();
    const auto of = [&](auto member) {
      std::vector<double> values;
      for (const Change& change : changes) values.push_back(static_cast<double>(change.*member));
      return spread(std::move(values));
    };
    out.begins_ms = of(&Change::begins_ms);
    out.complete_ms = of(&Change::complete_ms);
    out.begins_frames = of(&Change::begins_frame);
    out.complete_frames = of(&Change::complete_frame);
    out.most_mixed = static_cast<int>(of(&Change::mixed).max);
    // Each change says: later than its last frame with old light, at the latest with its first without. Noise
    // moves both by less than the light that goes unseen.
    const double last_incomplete_ms = of(&Change::incomplete_ms).max;
    out.steady = last_incomplete_ms < out.complete_ms.min + unseen_ms(out);
    out.needed_ms = out.steady ? std::max(last_incomplete_ms, out.complete_ms.min) : out.complete_ms.max;
    return out;
  }

  void recommend(Latency* latency) const {
    bool steady = display_.info().timed;
    double slowest = -1e300, frames = 0.0;
    for (const CameraLatency& camera : latency->cameras) {
      steady = steady && camera.steady;
      slowest = std::max(slowest, camera.needed_ms);
      frames = std::max(frames, camera.complete_frames.max);
      latency->margin_ms = std::max(latency->margin_ms, kLeastMarginMs + unseen_ms(camera));
    }
    latency->latency_ms = std::max(0.0, slowest + latency->margin_ms);
    latency->settle_frames = steady ? 0 : 1;
    latency->settle_without_latency = std::max(0, static_cast<int>(frames) - 1) + latency->settle_frames;
  }

  const Rig& rig_;
  PatternDisplay& display_;
  const LatencyOptions& options_;
  Streams streams_;
  std::mt19937_64 random_;
  std::vector<Watch> watches_;
  std::vector<LightLevels> levels_;
  std::vector<std::vector<Change>> changes_;  ///< by camera
  TimeNs period_ns_ = to_ns(1000.0), slowest_ns_ = 0;
  int n_seen_ = 0;
};

}  // namespace

Latency calibrate_latency(const Rig& rig, PatternDisplay& display, const LatencyOptions& options) {
  FT_CHECK(!rig.empty() && options.changes > kPatientChanges, "cameras and changes");
  return Calibration(rig, display, options).run();
}

std::vector<std::string> Latency::lines() const {
  std::vector<std::string> out;
  const auto text = [](const Spread& s) {
    return fmt::format("{:.2f} / {:.2f} / {:.2f}", s.min, s.median, s.max);
  };
  for (const CameraLatency& c : cameras) {
    out.push_back(fmt::format("{}: black {:.1f} DN, white {:.1f} DN, {} changes{}", c.camera, c.black_dn,
                              c.white_dn, c.changes,
                              c.discarded > 0 ? fmt::format(" ({} left out)", c.discarded) : ""));
    out.push_back(
        fmt::format("{}: new light begins in frame {:.0f} ... {:.0f}, whose exposure begins {} ms after "
                    "showing (least / median / most)",
                    c.camera, c.begins_frames.min, c.begins_frames.max, text(c.begins_ms)));
    out.push_back(
        fmt::format("{}: nothing else from frame {:.0f} ... {:.0f}, {} ms; at most {} frame{} of both",
                    c.camera, c.complete_frames.min, c.complete_frames.max, text(c.complete_ms), c.most_mixed,
                    c.most_mixed == 1 ? "" : "s"));
    if (!c.steady) out.push_back(c.camera + ": no single latency explains all changes; the longest counts");
  }
  out.push_back(fmt::format("use --latency-ms {:.1f} --settle {} (margin {:.1f} ms), or --settle {} alone",
                            latency_ms, settle_frames, margin_ms, settle_without_latency));
  return out;
}

}  // namespace fringetwin::capture
