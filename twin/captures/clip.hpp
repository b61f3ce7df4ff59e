// SPDX-License-Identifier: Apache-2.0
// Finds the gray value at which a sensor stops below its full scale (a full well that clips at 3600 of 4095):
// the images of one camera go in, the value and how often it occurs come out.
#pragma once
#include <optional>

#include "twin/captures/capture_set.hpp"

namespace fringetwin {

/// Returns the clip below full scale; nothing where the values just end, where they reach full scale, and for
/// irradiance. A clip is a plateau at the upper end of the histogram of the phase steps: at least 50 values,
/// eight times as many as stand below, hardly any above, none further above than three read noises of the
/// sensor, and the fringes of the pixels that hold it go on above it (the bright end of a fringe without
/// noise is a peak of the histogram, too).
std::optional<Clip> find_clip(const CameraImages& images, const Fringes& fringes, const Sensor& sensor);

}  // namespace fringetwin
