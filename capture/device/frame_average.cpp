// SPDX-License-Identifier: Apache-2.0
#include "capture/device/frame_average.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {
namespace {

/// Adds a frame to sums. None of the memory is another's, which the compiler cannot know of bytes: eight
/// pixels at a time instead of one.
void accumulate(const std::uint16_t* __restrict dn, std::size_t n, std::uint16_t clip_dn,
                std::uint32_t* __restrict sum, std::uint8_t* __restrict clipped) {
  for (std::size_t i = 0; i < n; ++i) {
    sum[i] += dn[i];
    clipped[i] = static_cast<std::uint8_t>(clipped[i] | (dn[i] >= clip_dn ? 1 : 0));
  }
}

}  // namespace

FrameAverage::FrameAverage(int camera_bits, int stored_bits)
    : camera_bits_(camera_bits),
      stored_bits_(stored_bits),
      clip_dn_(static_cast<std::uint16_t>((1 << std::min(camera_bits, stored_bits)) - 1)) {}

void FrameAverage::add(ImageU16 dn, const std::string& device) {
  if (camera_bits_ > stored_bits_) refuse_above_clip(dn, device);
  ++count_;
  if (count_ == 1) {
    first_ = std::move(dn);
    return;
  }
  FT_CHECK(dn.same_size(first_), "frames of one size");
  if (sum_.empty()) {
    sum_.assign(dn.size(), 0);
    clipped_.assign(dn.size(), 0);
    accumulate(first_.data.data(), dn.size(), clip_dn_, sum_.data(), clipped_.data());
  }
  accumulate(dn.data.data(), dn.size(), clip_dn_, sum_.data(), clipped_.data());
}

void FrameAverage::refuse_above_clip(const ImageU16& dn, const std::string& device) const {
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
  ImageF image(first_.width, first_.height);
  for (std::size_t i = 0; i < image.size(); ++i) {
    const bool clipped = count_ == 1 ? first_.data[i] >= clip_dn_ : clipped_[i] != 0;
    const std::uint32_t sum = count_ == 1 ? first_.data[i] : sum_[i];
    image.data[i] = static_cast<float>(clipped ? top : scale * sum / count_);
  }
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
