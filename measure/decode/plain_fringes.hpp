// SPDX-License-Identifier: Apache-2.0
// Takes out of the phase steps of one camera what makes phases ripple with the fringes: light and shifts that
// differ from image to image, and a waveform that is no sinusoid (docs/metrics/measure.md, "Plain fringes").
#pragma once
#include <vector>

#include "measure/light/light_factors.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Returns the images with steady light (with_steady_light()) and without the harmonics of
/// LightFactors::waveform and the shifts of LightFactors::shift_rad in these phase steps, whose phases then
/// hold none of them: of every pixel its own fringe is fitted to these steps alone, and the light that the
/// waveform adds to it is taken off, the noise left as it is; where the waveform varies is told by the steps
/// that told the light. Empty `steps`: all. Pixels with a clipped
/// value, and pitches that tell no waveform, have their light made steady alone.
CameraImages with_plain_fringes(CameraImages images, const Fringes& fringes, const LightFactors& light,
                                const LightOptions& options, std::vector<int> steps = {});

}  // namespace fringetwin::measure
