// SPDX-License-Identifier: Apache-2.0
// Takes a run whose two sides have images, and says where the simulated ones are far darker or brighter than
// the real ones: then modulation thresholds, noise and saturation are those of another rig.
#pragma once
#include <string>
#include <vector>

#include "cosim/run.hpp"

namespace fringetwin::cosim {

/// Returns the gray value that one in a thousand of the phase steps' values exceeds (of all images without
/// phase steps); NaN without images.
double peak_dn(const Twin& twin, const CameraImages& images);

/// Returns a sentence for each camera whose peaks differ by more than a factor of two, with the gain that
/// makes them alike; none where a side has no gray values.
std::vector<std::string> brightness_warnings(const Twin& twin, const std::vector<CameraImages>& real,
                                             const std::vector<CameraImages>& simulated);

/// Adds them to the warnings of the simulated side, where it was measured.
void add_brightness_warnings(Run& run);

}  // namespace fringetwin::cosim
