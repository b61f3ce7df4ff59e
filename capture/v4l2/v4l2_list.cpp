// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_list.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "capture/v4l2/v4l2_format.hpp"

namespace fringetwin::capture {
namespace {

std::optional<V4l2Listed> list_one(const std::shared_ptr<V4l2Api>& api, const std::string& path) {
  V4l2Listed listed;
  listed.path = path;
  try {
    const V4l2Device device(api, path, 0);
    listed.card = text_of(device.capability().card);
    listed.driver = text_of(device.capability().driver);
    listed.bus = text_of(device.capability().bus_info);
    const std::uint32_t caps = device.device_caps();
    const bool captures = (caps & V4L2_CAP_VIDEO_CAPTURE) != 0;
    listed.output = !captures && (caps & V4L2_CAP_VIDEO_OUTPUT) != 0;
    if ((caps & (V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_VIDEO_OUTPUT_MPLANE)) != 0 && !captures &&
        !listed.output)
      listed.trouble = "multi-planar formats only, which are not supported";
    else if (!captures && !listed.output)
      return std::nullopt;
    const auto type = listed.output ? V4L2_BUF_TYPE_VIDEO_OUTPUT : V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (const std::uint32_t fourcc : offered_formats(device, type))
      listed.offers.push_back(
          {fourcc_text(fourcc), pixel_format_of_fourcc(fourcc).has_value(), offered_sizes(device, fourcc)});
    if (listed.trouble.empty() &&
        std::ranges::none_of(listed.offers, [](const V4l2Offer& o) { return o.supported; }))
      listed.trouble = "offers none of " + pixel_format_names();
  } catch (const UserError& error) {
    listed.trouble = error.what();
  }
  return listed;
}

}  // namespace

std::vector<V4l2Listed> list_v4l2_devices(const std::shared_ptr<V4l2Api>& api) {
  std::vector<V4l2Listed> all;
  for (const std::string& path : api->device_paths())
    if (std::optional<V4l2Listed> listed = list_one(api, path)) all.push_back(std::move(*listed));
  return all;
}

std::vector<V4l2Listed> list_v4l2_cameras(const std::shared_ptr<V4l2Api>& api) {
  std::vector<V4l2Listed> cameras = list_v4l2_devices(api);
  std::erase_if(cameras, [](const V4l2Listed& listed) { return listed.output; });
  return cameras;
}

std::string describe(const V4l2Listed& listed) {
  std::string text = fmt::format("{}: {} ({}, {}){}\n", listed.path, listed.card, listed.driver, listed.bus,
                                 listed.output ? ", output" : "");
  if (!listed.trouble.empty()) text += "  cannot be used: " + listed.trouble + "\n";
  std::string others;
  for (const V4l2Offer& offer : listed.offers) {
    if (!offer.supported) {
      others += (others.empty() ? "" : ", ") + offer.format;
      continue;
    }
    text += "  " + offer.format;
    for (const std::string& size : offer.sizes) text += " " + size;
    text += "\n";
  }
  return others.empty() ? text : text + "  not supported: " + others + "\n";
}

}  // namespace fringetwin::capture
