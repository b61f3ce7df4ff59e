// SPDX-License-Identifier: Apache-2.0
// Sets a GenICam camera's pixel format, region and binning to what the twin's camera has.
#pragma once
#include "capture/device/pfnc_format.hpp"
#include "capture/genicam/genicam_options.hpp"
#include "capture/genicam/genicam_settings.hpp"

namespace fringetwin::capture {

/// Throws UserError(usage) for features in `controls` that other options set.
void check_controls(const GenicamCameraOptions& options);

/// Undoes binning, decimation and mirrors that an earlier program left, but for what `controls` name.
void reset_geometry(const GenicamSettings& settings, const std::set<std::string>& named);

/// Returns the layout of the frames. A region smaller than the sensor is taken only where the user names its
/// corner (OffsetX, OffsetY): the twin's principal point counts from there. Throws UserError(device).
PfncLayout set_region_and_format(const GenicamSettings& settings, const GenicamCameraOptions& options);

}  // namespace fringetwin::capture
