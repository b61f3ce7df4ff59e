// SPDX-License-Identifier: Apache-2.0
// Takes still series with their exposures and returns how straight the level follows the exposure: a line
// weighted as EMVA 1288 does, over the parts of the image that no
// series saturates.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/photometry/photometry.hpp"

namespace fringetwin::calib {

/// Returns the line through three series with an exposure or more; nullopt where there are fewer, or all have
/// one exposure. Blocks of pixels that one of them saturates are left out of all, and series that saturate
/// nearly all of them take no part: `warnings` say so. `saturation_dn`: from this value on a pixel is
/// saturated.
std::optional<ExposureLinearity> exposure_linearity(const std::vector<StillSeries>& stills,
                                                    double saturation_dn, const std::string& camera,
                                                    std::vector<std::string>& warnings);

}  // namespace fringetwin::calib
