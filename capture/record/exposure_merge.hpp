// SPDX-License-Identifier: Apache-2.0
// Merges one sequence recorded at several exposures into one with a wider range of light.
#pragma once
#include <functional>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin::capture {

/// The sequence at one exposure; `load(k)` reads its k-th image, in DN of the file.
struct BracketExposure {
  double exposure_ms = 0.0;
  std::function<ImageF(std::size_t)> load;
};

/// Each pixel is taken from the longest exposure at which none of its images is saturated, all its images
/// from the same one, so that its phase never mixes exposures; values are scaled to the shortest exposure t0:
///   DN = black + (DN_t - black) t0/t.
/// Pixels saturated even there get max_dn. `store(k, image)` takes the merged images in order.
void merge_exposures(std::vector<BracketExposure> exposures, std::size_t n_images, double black_level_dn,
                     double max_dn, const std::function<void(std::size_t, const ImageF&)>& store);

}  // namespace fringetwin::capture
