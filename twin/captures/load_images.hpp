// SPDX-License-Identifier: Apache-2.0
// Loads the images that a capture set names of one camera. Internal to twin/captures.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "twin/captures/capture_set.hpp"

namespace fringetwin {

struct LoadedImages {
  std::vector<GrayImage> images = {};  ///< sequence order
  std::optional<GrayImage> white = {}, black = {};
};

/// Returns whether the camera's images are EXR, irradiance; it must have some.
bool has_radiance(const CaptureCamera& source);

/// Loads the images by load(file), in parallel. Throws UserError(input) where EXR stands beside other images.
LoadedImages load_images(const CaptureCamera& source,
                         const std::function<ImageF(const std::filesystem::path&)>& load);

}  // namespace fringetwin
