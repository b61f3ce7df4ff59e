// SPDX-License-Identifier: Apache-2.0
// Finds matches of pixels whose surface the second camera does not see.
#pragma once
#include <Eigen/Core>

#include "twin/image/image.hpp"

namespace fringetwin::measure {

/// Where a near surface hides a strip of a far one from camera 1, the strip's coordinates are missing in its
/// image: they jump from one pixel to the next. A jump that is small beside the noise of a pixel is read as a
/// slope, and the pixels of camera 0 that see the strip all meet there: their points lie on rays of camera 1,
/// on a slide from one surface to the other.
/// Marks (1) points about which the plane through the neighbours is seen by camera 1 more nearly edge-on than
/// 7 degrees, or from behind, whatever the noise makes of it (3 sigma), and by camera 0 much less so; and
/// those of their neighbours that camera 1 has within a pixel of them.
/// p_cam0_mm: the point of each pixel of camera 0, in its frame; NaN where there is none. sigma_mm: standard
/// deviation of each along its ray, on its own; 0: what noise makes of slopes is not allowed for.
/// center1_cam0_mm: where camera 1 stands. step1: lateral distance of its neighbouring pixels, per mm of
/// depth.
ImageU8 hidden_matches(const Image<Eigen::Vector3d>& p_cam0_mm, const ImageF& sigma_mm,
                       const Eigen::Vector3d& center1_cam0_mm, double step1);

}  // namespace fringetwin::measure
