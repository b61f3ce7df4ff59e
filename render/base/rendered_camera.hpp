// SPDX-License-Identifier: Apache-2.0
// Holds the irradiance images that one camera receives, before its sensor makes gray values of them.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "render/base/transport.hpp"
#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::render {

struct RenderedCamera : TraceRecord {
  std::string camera;
  std::vector<ImageF> irradiance;      ///< E per image, sequence order
  std::optional<ImageF> white, black;  ///< when needs_white_black(), or asked for
  double total_ms = 0.0;
};

/// The same, its images as they are kept beside all else of a run: those of phase steps share what they are
/// sums of, where that takes less memory.
struct KeptCamera {
  RenderedCamera rendered;  ///< without irradiance
  std::vector<GrayImage> irradiance;
};

}  // namespace fringetwin::render
