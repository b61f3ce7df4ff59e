// SPDX-License-Identifier: Apache-2.0
// Cameras that look at even light: DN = black + gain(pixel) x integral of the light over the exposure +
// noise, in closed form. For *_test.cpp only.
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"

namespace fringetwin::testing {

/// The light goes from one level to the next in `rise_ms`, beginning `latency_ms` (and up to `jitter_ms`
/// more) after a picture is shown.
struct EvenWorld {
  double latency_ms = 20.0, jitter_ms = 0.0, rise_ms = 0.0;
  double flip_wait_ms = 16.7;  ///< showing takes up to so long
  bool lamp_on = true, timed = true;
  std::mt19937_64 random{7};

  struct Change {
    double from_ms, step;
  };
  capture::TimeNs now_ns = 0;
  double level = 0.0;
  std::vector<Change> changes;

  double any(double most) { return std::uniform_real_distribution<double>(0.0, 1.0)(random) * most; }

  /// Integral of the light from the beginning of time, level x ms.
  double light_until(double t_ms) const {
    double sum = 0.0;
    for (const Change& change : changes) {
      const double t = t_ms - change.from_ms;
      if (t <= 0.0) continue;
      sum += change.step * (t < rise_ms ? t * t / (2.0 * rise_ms) : t - rise_ms / 2.0);
    }
    return sum;
  }
};

struct EvenCameraOptions {
  int width = 32, height = 24, bits = 8;
  double period_ms = 16.7, offset_ms = 0.0, exposure_ms = 10.0;
  double black_dn = 4.0, ambient = 0.0;  ///< ambient: level that is always there
  double dn_per_ms = 15.0;               ///< of white, at the brightest pixel; the darkest has a quarter
  double noise_dn = 0.0;
  bool stamped_at_begin = false, exposure_known = true;
  std::set<std::uint32_t> lost = {};
  capture::ExposureRange range = {0.1, 100.0, 0.01};
  int exposure_late_frames = 0;  ///< frames still taken with the exposure before
  int flash_at = -1;  ///< frames with an even number (0) or an odd one (1) get `flash` times the light
  double flash = 1.0;
};

class EvenCamera : public capture::CameraDevice {
 public:
  EvenCamera(std::shared_ptr<EvenWorld> world, EvenCameraOptions options)
      : world_(std::move(world)), o_(std::move(options)), taken_ms_(o_.exposure_ms), next_ms_(o_.offset_ms) {}

  capture::CameraInfo info() const override {
    capture::CameraInfo info;
    info.device = "even";
    info.width = o_.width;
    info.height = o_.height;
    info.bit_depth = o_.bits;
    info.timestamp_at_exposure_start = o_.stamped_at_begin;
    return info;
  }
  void start() override {}
  void stop() noexcept override {}
  void check_input() override {}
  void drain() override {
    while (capture::to_ns(next_ms_ + taken_ms_) <= world_->now_ns) skip();
  }
  std::optional<capture::ExposureRange> exposure_range() const override { return o_.range; }
  std::optional<double> exposure_ms() const override {
    return o_.exposure_known ? std::optional(o_.exposure_ms) : std::nullopt;
  }
  double set_exposure_ms(double exposure_ms) override {
    const double steps = std::round((exposure_ms - o_.range.min_ms) / o_.range.step_ms);
    o_.exposure_ms = std::clamp(o_.range.min_ms + steps * o_.range.step_ms, o_.range.min_ms, o_.range.max_ms);
    late_frames_ = o_.exposure_late_frames;
    if (late_frames_ == 0) taken_ms_ = o_.exposure_ms;
    return o_.exposure_ms;
  }
  capture::TimeNs now_ns() const override { return world_->now_ns; }

  /// Returns the DN that white adds per ms at a pixel: from 1 to 1/4 of the brightest, evenly over the
  /// pixels' numbers.
  double gain(std::size_t pixel) const {
    const double place = static_cast<double>(pixel) / static_cast<double>(o_.width * o_.height - 1);
    return o_.dn_per_ms * (1.0 - 0.75 * place);
  }

  capture::Frame next_frame(std::chrono::milliseconds, Pixels) override {
    while (o_.lost.contains(sequence_)) skip();
    const double end_ms = next_ms_ + taken_ms_;
    capture::Frame frame;
    frame.sequence = sequence_;
    frame.timestamp_ns = capture::to_ns(o_.stamped_at_begin ? next_ms_ : end_ms);
    const double flash = static_cast<int>(sequence_ % 2) == o_.flash_at ? o_.flash : 1.0;
    const double light =
        flash * (o_.ambient * taken_ms_ +
                 (world_->lamp_on ? world_->light_until(end_ms) - world_->light_until(next_ms_) : 0.0));
    frame.dn = capture::ImageU16(o_.width, o_.height);
    std::normal_distribution<double> noise(0.0, 1.0);
    for (std::size_t i = 0; i < frame.dn.size(); ++i) {
      const double dn =
          o_.black_dn + gain(i) * light + (o_.noise_dn > 0.0 ? o_.noise_dn * noise(world_->random) : 0.0);
      frame.dn.data[i] = static_cast<std::uint16_t>(std::clamp(std::round(dn), 0.0, (1 << o_.bits) - 1.0));
    }
    world_->now_ns = std::max(world_->now_ns, capture::to_ns(end_ms));
    skip();
    return frame;
  }

  EvenCameraOptions& options() { return o_; }

 private:
  void skip() {
    next_ms_ += std::max(o_.period_ms, taken_ms_);
    ++sequence_;
    if (late_frames_ > 0 && --late_frames_ == 0) taken_ms_ = o_.exposure_ms;
  }
  std::shared_ptr<EvenWorld> world_;
  EvenCameraOptions o_;
  double taken_ms_;  ///< exposure of the next frame
  int late_frames_ = 0;
  double next_ms_;
  std::uint32_t sequence_ = 0;
};

class EvenDisplay : public capture::PatternDisplay {
 public:
  explicit EvenDisplay(std::shared_ptr<EvenWorld> world) : world_(std::move(world)) {}
  capture::DisplayInfo info() const override {
    capture::DisplayInfo info;
    info.device = "even";
    info.width = 8;
    info.height = 6;
    info.timed = world_->timed;
    return info;
  }
  capture::Shown show(const capture::Pattern& pattern, const ImageF&) override {
    world_->now_ns += capture::to_ns(world_->any(world_->flip_wait_ms));
    const double late_ms = world_->latency_ms + world_->any(world_->jitter_ms);
    const double from_ms = static_cast<double>(world_->now_ns) / capture::kNsPerMs + late_ms;
    world_->changes.push_back({from_ms, pattern.level - world_->level});
    world_->level = pattern.level;
    return {world_->now_ns, world_->changes.size(), world_->timed};
  }

 private:
  std::shared_ptr<EvenWorld> world_;
};

struct EvenRig {
  std::shared_ptr<EvenWorld> world = std::make_shared<EvenWorld>();
  capture::Rig cameras;
  EvenDisplay display{world};
  void add(const std::string& name, const EvenCameraOptions& options) {
    cameras.push_back({name, options.bits, std::make_unique<EvenCamera>(world, options)});
  }
  EvenCamera& camera(std::size_t index) { return static_cast<EvenCamera&>(*cameras[index].device); }
};

}  // namespace fringetwin::testing
