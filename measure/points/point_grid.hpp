// SPDX-License-Identifier: Apache-2.0
// Puts the points of a cloud back on the image pixels they come from.
#pragma once
#include "measure/points/points.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::measure {

/// Returns the index of the point of each pixel, -1 where there is none. Points outside the image are left
/// out.
Image<int> point_grid(const PointCloud& cloud, int width_px, int height_px);

}  // namespace fringetwin::measure
