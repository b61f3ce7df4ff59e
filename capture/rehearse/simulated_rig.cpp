// SPDX-License-Identifier: Apache-2.0
#include "capture/rehearse/simulated_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/sensor/sensor.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::capture {
namespace {

constexpr double kLeastExposureMs = 0.01, kGreatestExposureMs = 1000.0;
constexpr TimeNs kDriverBuffers = 4;

std::uint64_t noise_seed(std::uint64_t seed, double exposure_ms) {
  return seed ^ (std::bit_cast<std::uint64_t>(exposure_ms) * 0x9E3779B97F4A7C15ull);
}

}  // namespace

struct SimulatedRig::World {
  /// A pattern and since when its light is there.
  struct Light {
    TimeNs from_ns = 0;
    Pattern pattern;
    double share = 1.0;  ///< of an exposure
  };
  SimulatedOptions options;
  std::vector<Camera> cameras;
  std::string device;
  ProjectorResponse response;
  int projector_width = 0, projector_height = 0;
  std::vector<render::RenderedCamera> rendered;  ///< white and black among it
  TimeNs now_ns = 0;
  std::uint64_t n_shown = 0;
  std::vector<Light> lights;  ///< in order of time

  /// Returns the lights that shone during [begin, end), each with its share.
  std::vector<Light> during(TimeNs begin_ns, TimeNs end_ns) const {
    std::vector<Light> found;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const TimeNs from = std::max(begin_ns, i == 0 ? begin_ns : lights[i].from_ns);
      const TimeNs to = i + 1 < lights.size() ? std::min(end_ns, lights[i + 1].from_ns) : end_ns;
      if (to <= from) continue;
      found.push_back(lights[i]);
      found.back().share = static_cast<double>(to - from) / static_cast<double>(end_ns - begin_ns);
    }
    return found;
  }

  /// Adds `share` of a pattern's irradiance. An even field of level v is black + r(v) (white - black), since
  /// the light is linear in the value behind the projector's response.
  void add(std::size_t camera, const Light& light, ImageF& sum) const {
    const render::RenderedCamera& images = rendered[camera];
    const auto share = static_cast<float>(light.share);
    if (light.pattern.index >= 0) {
      const ImageF& image = images.irradiance.at(light.pattern.index);
      for (std::size_t i = 0; i < sum.size(); ++i) sum.data[i] += share * image.data[i];
      return;
    }
    const double dark = response(0.0), bright = response(1.0);
    const auto level =
        static_cast<float>(bright == dark ? 1.0 : (response(light.pattern.level) - dark) / (bright - dark));
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum.data[i] += share * ((*images.black)[i] + level * ((*images.white)[i] - (*images.black)[i]));
  }
};

namespace {

using World = SimulatedRig::World;
using Light = World::Light;

class SimulatedCamera : public CameraDevice {
 public:
  SimulatedCamera(std::shared_ptr<World> world, std::size_t index)
      : world_(std::move(world)), index_(index), exposure_ms_(reference_exposure_ms()) {}

  CameraInfo info() const override {
    CameraInfo info;
    const Camera& camera = world_->cameras[index_];
    info.device = "twin camera \"" + camera.name + "\"";
    info.width = camera.lens.width();
    info.height = camera.lens.height();
    info.bit_depth = camera.sensor.bit_depth;
    info.period_ms = period_ms();
    info.provenance = {{"driver", "fringetwin renderer on " + world_->device},
                       {"format", fmt::format("{} bit", info.bit_depth)},
                       {"exposure_ms", fmt::format("{}", exposure_ms_)},
                       {"seed", fmt::format("{}", world_->options.seed)}};
    return info;
  }

  void start() override {
    running_ = true;
    next_begin_ns_ = first_begin_after(world_->now_ns);
  }
  void stop() noexcept override { running_ = false; }

  Frame next_frame(std::chrono::milliseconds, Pixels pixels) override {
    FT_CHECK(running_, "a frame of a camera that was not started");
    const TimeNs begin = next_begin_ns_;
    const TimeNs end = begin + to_ns(exposure_ms_);
    Frame frame{.sequence = sequence_++, .timestamp_ns = end};
    if (pixels == Pixels::keep) frame.dn = picture(begin, end);
    next_begin_ns_ = begin + to_ns(period_ms());
    world_->now_ns = std::max(world_->now_ns, end);
    return frame;
  }

  void drain() override {
    const TimeNs period = to_ns(period_ms());
    while (next_begin_ns_ + to_ns(exposure_ms_) <= world_->now_ns) {
      next_begin_ns_ += period;
      ++sequence_;
    }
  }
  void check_input() override {}

  std::optional<ExposureRange> exposure_range() const override {
    return ExposureRange{kLeastExposureMs, kGreatestExposureMs, 1e-6};
  }
  std::optional<double> exposure_ms() const override { return exposure_ms_; }
  double set_exposure_ms(double exposure_ms) override {
    if (!(exposure_ms >= kLeastExposureMs && exposure_ms <= kGreatestExposureMs))
      throw UserError(ExitCode::device, info().device,
                      fmt::format("takes exposures of {} to {} ms, not {}", kLeastExposureMs,
                                  kGreatestExposureMs, exposure_ms));
    exposure_ms_ = exposure_ms;
    return exposure_ms_;
  }

  TimeNs now_ns() const override { return world_->now_ns; }

 private:
  double reference_exposure_ms() const {
    return world_->cameras[index_].sensor.exposure_ms.value_or(world_->options.default_exposure_ms);
  }
  double period_ms() const { return std::max(world_->options.period_ms, exposure_ms_); }

  /// The camera's frames begin at offset + k period.
  TimeNs first_begin_after(TimeNs now) const {
    const TimeNs offset = to_ns(world_->options.camera_offset_ms * static_cast<double>(index_));
    const TimeNs period = to_ns(period_ms());
    const TimeNs k = now <= offset ? 0 : (now - offset + period - 1) / period;
    return offset + k * period;
  }

  ImageU16 picture(TimeNs begin, TimeNs end) {
    const Camera& camera = world_->cameras[index_];
    ImageF irradiance(camera.lens.width(), camera.lens.height());
    const std::vector<Light> lights = world_->during(begin, end);
    for (const Light& light : lights) world_->add(index_, light, irradiance);
    if (exposure_ms_ != reference_exposure_ms()) {
      const auto factor = static_cast<float>(exposure_ms_ / reference_exposure_ms());
      for (float& value : irradiance.data) value *= factor;
    }
    const ImageF gray =
        render::expose(irradiance, camera.sensor, noise_seed(world_->options.seed, exposure_ms_),
                       static_cast<std::uint32_t>(index_), noise_number(lights));
    ImageU16 dn(gray.width, gray.height);
    std::transform(gray.data.begin(), gray.data.end(), dn.data.begin(),
                   [](float value) { return static_cast<std::uint16_t>(value); });
    return dn;
  }

  /// Counts the pictures of one showing, so that a resumed run sees what an unbroken one would have seen.
  std::uint32_t noise_number(const std::vector<Light>& lights) {
    if (lights.size() != 1) return 0x80000000u + mixed_++;
    const Light& light = lights.front();
    if (light.from_ns != counted_from_ns_) n_of_showing_ = 0;
    counted_from_ns_ = light.from_ns;
    const auto pattern = static_cast<std::uint32_t>(
        light.pattern.index >= 0 ? light.pattern.index : 1024 + std::lround(1000.0 * light.pattern.level));
    return pattern * 65536u + (n_of_showing_++ & 0xFFFFu);
  }

  std::shared_ptr<World> world_;
  std::size_t index_;
  double exposure_ms_;
  bool running_ = false;
  std::uint32_t sequence_ = 0, n_of_showing_ = 0, mixed_ = 0;
  TimeNs counted_from_ns_ = -1;
  TimeNs next_begin_ns_ = 0;
};

class SimulatedDisplay : public PatternDisplay {
 public:
  explicit SimulatedDisplay(std::shared_ptr<World> world) : world_(std::move(world)) {}

  DisplayInfo info() const override {
    DisplayInfo info{.device = "twin projector",
                     .width = world_->projector_width,
                     .height = world_->projector_height,
                     .bit_depth = 16,
                     .timed = true,
                     .provenance = {{"driver", "simulated"},
                                    {"latency_ms", fmt::format("{}", world_->options.latency_ms)}}};
    return info;
  }

  Shown show(const Pattern& pattern, const ImageF&) override {
    const Shown shown{world_->now_ns, ++world_->n_shown, true};
    world_->lights.push_back({shown.at_ns + to_ns(world_->options.latency_ms), pattern, 1.0});
    // Frames still to come begin after now less the driver's buffers: older light is seen by none of them.
    const TimeNs oldest =
        world_->now_ns - kDriverBuffers * to_ns(std::max(world_->options.period_ms, kGreatestExposureMs));
    while (world_->lights.size() > 2 && world_->lights[1].from_ns < oldest)
      world_->lights.erase(world_->lights.begin());
    return shown;
  }

 private:
  std::shared_ptr<World> world_;
};

}  // namespace

SimulatedRig::SimulatedRig(const Twin& twin, const render::Sampling& sampling, render::Renderer& renderer,
                           const SimulatedOptions& options)
    : world_(std::make_shared<World>()) {
  FT_CHECK(twin.projector.has_value(), "a rig with a projector");
  World& world = *world_;
  world.options = options;
  world.cameras = twin.cameras;
  world.device = renderer.device().name;
  world.response = twin.projector->response;
  world.projector_width = twin.projector->lens.width();
  world.projector_height = twin.projector->lens.height();
  for (std::size_t i = 0; i < twin.cameras.size(); ++i)
    world.rendered.push_back(renderer.render(twin, i, sampling, options.seed, true));
  world.lights.push_back({0, even_field(0.0, "off"), 1.0});
}

std::unique_ptr<CameraDevice> SimulatedRig::camera(std::size_t index) const {
  FT_CHECK(index < world_->cameras.size(), "a camera of the twin");
  return std::make_unique<SimulatedCamera>(world_, index);
}

std::unique_ptr<PatternDisplay> SimulatedRig::display() const {
  return std::make_unique<SimulatedDisplay>(world_);
}

}  // namespace fringetwin::capture
