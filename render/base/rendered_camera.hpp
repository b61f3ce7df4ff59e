// SPDX-License-Identifier: Apache-2.0
// Holds the irradiance images that one camera receives, before its sensor makes gray values of them.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/base/transport.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::render {

struct RenderedCamera {
  std::string camera;
  std::vector<ImageF> irradiance;      ///< E per image, sequence order
  std::optional<ImageF> white, black;  ///< when needs_white_black(), or asked for
  Image<std::int32_t> object;          ///< as in Transport
  Sampling sampling;
  double trace_ms = 0.0, total_ms = 0.0;
  std::uint64_t rays = 0;
  std::optional<ErrorEstimate> estimate;
};

}  // namespace fringetwin::render
