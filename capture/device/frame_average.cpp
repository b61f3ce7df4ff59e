// SPDX-License-Identifier: Apache-2.0
#include "capture/device/frame_average.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {

FrameAverage::FrameAverage(int camera_bits, int stored_bits)
    : camera_bits_(camera_bits),
      stored_bits_(stored_bits),
      clip_dn_(static_cast<std::uint16_t>((1 << std::min(camera_bits, stored_bits)) - 1)) {}

void FrameAverage::add(const ImageU16& dn, const std::string& device) {
  if (count_ == 0) {
    width_ = dn.width;
    height_ = dn.height;
    sum_.assign(dn.size(), 0);
    clipped_.assign(dn.size(), 0);
  }
  FT_CHECK(dn.width == width_ && dn.height == height_, "frames of one size");
  for (std::size_t i = 0; i < dn.size(); ++i) {
    sum_[i] += dn.data[i];
    clipped_[i] |= static_cast<std::uint8_t>(dn.data[i] >= clip_dn_);
  }
  ++count_;
  if (camera_bits_ <= stored_bits_) return;
  const std::uint16_t highest = *std::ranges::max_element(dn.data);
  if (highest > clip_dn_)
    throw UserError(
        ExitCode::device, device,
        fmt::format("delivers the value {}, above the {} of bit_depth = {}", highest, clip_dn_, stored_bits_),
        "set bit_depth in [camera.sensor] to what the sensor has, or --shift where its values fill the "
        "high bits");
}

ImageF FrameAverage::stored() const {
  FT_CHECK(count_ > 0, "an average of frames");
  const double top = static_cast<double>((1 << stored_bits_) - 1);
  const double scale = stored_bits_ > camera_bits_ ? top / static_cast<double>((1 << camera_bits_) - 1) : 1.0;
  ImageF image(width_, height_);
  for (std::size_t i = 0; i < sum_.size(); ++i)
    image.data[i] = clipped_[i] ? static_cast<float>(top) : static_cast<float>(scale * sum_[i] / count_);
  return image;
}

void check_depths(const std::string& camera, int camera_bits, int stored_bits, bool several_frames) {
  if (stored_bits <= camera_bits || several_frames) return;
  throw UserError(
      ExitCode::usage, fmt::format("camera \"{}\"", camera),
      fmt::format("delivers {} bit, the twin has bit_depth = {}", camera_bits, stored_bits),
      fmt::format("set bit_depth = {}, choose a deeper --format, or record with --average", camera_bits));
}

}  // namespace fringetwin::capture
