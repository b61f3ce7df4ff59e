// SPDX-License-Identifier: Apache-2.0
// Holds the irradiance images that one camera receives, before its sensor makes gray values of them.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "render/base/transport.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::render {

struct RenderedCamera : TraceRecord {
  std::string camera;
  std::vector<ImageF> irradiance;      ///< E per image, sequence order
  std::optional<ImageF> white, black;  ///< when needs_white_black(), or asked for
  double total_ms = 0.0;
};

}  // namespace fringetwin::render
