// SPDX-License-Identifier: Apache-2.0
// Tells whether the twin is as noisy as the rig: takes the redundancy of the real phase steps, or with three
// steps their means, and holds it against the noise that the twin's sensor model predicts.
#pragma once
#include <optional>
#include <vector>

#include "compare/result/rows.hpp"
#include "measure/decode/decode.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns the variance of a gray value of this level: the sensor's model and the rounding to whole values.
double sensor_variance_dn2(const Sensor& sensor, double dn);

/// Returns one row per direction of a camera: `real` are its images in sequence order, `decode` what
/// `used_steps` (empty = all) of them gave. Nothing for a direction without phase steps, of irradiance
/// images, or with too few values. `irradiance`, may be null: the twin's own images of that camera, whose
/// phase is taken off the real one, so that bends of the surface are no noise.
std::vector<NoiseRow> noise_rows(const Camera& camera, const Fringes& fringes, const CameraImages& real,
                                 const measure::CameraDecode& decode, const std::vector<int>& used_steps,
                                 const CameraImages* irradiance = nullptr);

}  // namespace fringetwin::compare
