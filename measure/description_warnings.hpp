// SPDX-License-Identifier: Apache-2.0
// Holds what a capture set and the rig say against the description of its fringes, in sentences for the user.
#pragma once
#include <vector>

#include "measure/description/doubts.hpp"
#include "measure/measurement.hpp"

namespace fringetwin::measure {

/// Returns what speaks against [fringes] of the twin in a real capture set: the doubts of every camera
/// (description/doubts.hpp), first of all those about pitches, which take the place of what they explain of
/// the same camera; images of two cameras that are exchanged or turned; and a direction that tells less of
/// the depth than the other would. `simulated`: the same measured on the rendered images, with which more can
/// be seen; may be null.
std::vector<Doubt> description_warnings(const Twin& twin, const std::vector<CameraImages>& images,
                                        const Measurement& real, const Measurement* simulated);

/// Puts doubts before the other warnings: other images than described are why the rest fails.
void put_first(const std::vector<Doubt>& doubts, std::vector<std::string>& warnings);

}  // namespace fringetwin::measure
