// SPDX-License-Identifier: Apache-2.0
// Lists the cameras this machine has and what they offer.
#pragma once
#include "capture/v4l2/v4l2_api.hpp"

namespace fringetwin::capture {

struct V4l2Offer {
  std::string format;  ///< "Y16", also formats that are not supported
  bool supported = false;
  std::vector<std::string> sizes;
};

struct V4l2Listed {
  std::string path, card, driver, bus;
  bool output = false;  ///< shows pictures instead of taking them
  std::vector<V4l2Offer> offers;
  std::string trouble;  ///< why it cannot be used; "" when it can
};

/// Devices that neither capture nor show are left out.
std::vector<V4l2Listed> list_v4l2_devices(const std::shared_ptr<V4l2Api>& api = kernel_v4l2());
/// The cameras among them.
std::vector<V4l2Listed> list_v4l2_cameras(const std::shared_ptr<V4l2Api>& api = kernel_v4l2());
/// Some lines of text.
std::string describe(const V4l2Listed& listed);

}  // namespace fringetwin::capture
