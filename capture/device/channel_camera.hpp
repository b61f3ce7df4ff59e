// SPDX-License-Identifier: Apache-2.0
// A colour camera as the recording of one colour sees it: of each frame of the whole sensor the pixels of the
// twin's channel, nothing made up from others.
#pragma once
#include "capture/device/camera_device.hpp"
#include "twin/mosaic_channel.hpp"

namespace fringetwin::capture {

class ChannelCamera final : public CameraDevice {
 public:
  /// Throws UserError(device) unless the sensor's frames have the channel's sensor_px.
  ChannelCamera(std::unique_ptr<CameraDevice> sensor, MosaicChannel channel);

  CameraInfo info() const override;
  void start() override { sensor_->start(); }
  void stop() noexcept override { sensor_->stop(); }
  void trigger() override { sensor_->trigger(); }
  Frame next_frame(std::chrono::milliseconds timeout, Pixels pixels) override;
  void drain() override { sensor_->drain(); }
  void check_input() override { sensor_->check_input(); }

  std::optional<ExposureRange> exposure_range() const override { return sensor_->exposure_range(); }
  std::optional<double> exposure_ms() const override { return sensor_->exposure_ms(); }
  double set_exposure_ms(double exposure_ms) override { return sensor_->set_exposure_ms(exposure_ms); }
  TimeNs now_ns() const override { return sensor_->now_ns(); }

 private:
  std::unique_ptr<CameraDevice> sensor_;
  MosaicChannel channel_;
};

}  // namespace fringetwin::capture
