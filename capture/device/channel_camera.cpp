// SPDX-License-Identifier: Apache-2.0
#include "capture/device/channel_camera.hpp"

#include <fmt/format.h>

namespace fringetwin::capture {

ChannelCamera::ChannelCamera(std::unique_ptr<CameraDevice> sensor, MosaicChannel channel)
    : sensor_(std::move(sensor)), channel_(std::move(channel)) {
  const CameraInfo info = sensor_->info();
  if (info.width != channel_.sensor_px.x() || info.height != channel_.sensor_px.y())
    throw UserError(ExitCode::device, info.device,
                    fmt::format("delivers {} x {} px, the whole colour sensor of the twin has {} x {}",
                                info.width, info.height, channel_.sensor_px.x(), channel_.sensor_px.y()),
                    "check imagersize");
}

CameraInfo ChannelCamera::info() const {
  CameraInfo info = sensor_->info();
  const Eigen::Vector2i size_px = channel_.image_px();
  info.width = size_px.x();
  info.height = size_px.y();
  info.provenance["channel"] = text_of(channel_);
  return info;
}

Frame ChannelCamera::next_frame(std::chrono::milliseconds timeout, Pixels pixels) {
  Frame frame = sensor_->next_frame(timeout, pixels);
  if (!frame.dn.empty()) frame.dn = channel_image(frame.dn, channel_);
  return frame;
}

}  // namespace fringetwin::capture
