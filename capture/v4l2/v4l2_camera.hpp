// SPDX-License-Identifier: Apache-2.0
// A camera behind Linux' V4L2: single-planar capture into mapped buffers.
#pragma once
#include <utility>

#include "capture/v4l2/v4l2_controls.hpp"
#include "capture/v4l2/v4l2_format.hpp"

namespace fringetwin::capture {

struct V4l2CameraOptions {
  std::string device = "/dev/video0";
  V4l2FormatWish format;
  std::optional<double> exposure_ms;
  std::optional<std::int64_t> gain;
  std::vector<std::pair<std::string, std::string>>
      controls;  ///< name, value; also an automatic that is to stay on
  unsigned buffers = 4;
  std::chrono::milliseconds start_pause{50};  ///< between a refused start and the next try
};

class V4l2Camera final : public CameraDevice {
 public:
  /// Everything is set and read back here; throws UserError(device).
  explicit V4l2Camera(V4l2CameraOptions options, std::shared_ptr<V4l2Api> api = kernel_v4l2());

  CameraInfo info() const override;
  void start() override;
  void stop() noexcept override;
  Frame next_frame(std::chrono::milliseconds timeout, Pixels pixels) override;
  void drain() override;
  void check_input() override;

  std::optional<ExposureRange> exposure_range() const override;
  std::optional<double> exposure_ms() const override;
  double set_exposure_ms(double exposure_ms) override;

  const V4l2Device& device() const { return device_; }
  /// Returns how often start() was refused before it went through, since the camera was opened.
  int refused_starts() const { return refused_starts_; }

 private:
  struct Exposure {
    const V4l2Control* control = nullptr;
    double unit_ms = 0.0;
  };
  static std::optional<Exposure> find_exposure(const V4l2Controls& controls, int width);
  void apply_controls();
  int try_start();
  void await_frame(std::chrono::steady_clock::time_point deadline) const;
  Frame to_frame(const v4l2_buffer& buffer, Pixels pixels) const;

  V4l2CameraOptions options_;
  V4l2Device device_;
  V4l2Agreed agreed_;
  V4l2Controls controls_;
  std::optional<Exposure> exposure_;
  std::map<std::string, std::string> control_values_;  ///< as set: asking for all takes long on a slow bus
  V4l2Buffers buffers_;
  bool streaming_ = false;
  std::optional<std::uint32_t> buffer_flags_;
  int refused_starts_ = 0;
};

}  // namespace fringetwin::capture
