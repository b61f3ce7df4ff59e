// SPDX-License-Identifier: Apache-2.0
// Takes still series with their exposures and returns how straight the level follows the exposure: a line
// weighted as EMVA 1288 does, over the parts of the image that no
// series saturates.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/photometry/photon_transfer.hpp"
#include "twin/image/gray_image.hpp"

namespace fringetwin::calib {

/// Stills of one scene that nothing moved in, at one exposure.
struct StillSeries {
  std::string name;  ///< as the user gave it
  std::vector<GrayImage> images;
  std::optional<double> exposure_ms;
};

/// Mean level against exposure: level = black + slope * exposure.
struct ExposureLinearity {
  std::vector<double> exposure_ms, level_dn, residual_percent;  ///< of the line at that exposure
  Estimate slope_dn_per_ms, offset_dn;
  double worst_percent = 0.0;
};

/// Returns the line through three series with an exposure or more; nullopt where there are fewer, or all have
/// one exposure. Blocks of pixels that one of them saturates are left out of all, and series that saturate
/// nearly all of them take no part: `warnings` say so. `saturation_dn`: from this value on a pixel is
/// saturated.
std::optional<ExposureLinearity> exposure_linearity(const std::vector<StillSeries>& stills,
                                                    double saturation_dn, const std::string& camera,
                                                    std::vector<std::string>& warnings);

}  // namespace fringetwin::calib
