// SPDX-License-Identifier: Apache-2.0
// Tells whether the theory of the noise knows a twin (docs/metrics/study.md, "Outside of the theory").
#pragma once
#include <string>

#include "twin/twin.hpp"

namespace fringetwin::study {

/// Returns the first thing that the twin has and the theory of the noise does not know, by its key and value
/// where a key says it: "camera.left.psf_px = 2". Empty where the theory knows all of the twin.
std::string outside_noise_theory(const Twin& twin, const std::string& object);

}  // namespace fringetwin::study
