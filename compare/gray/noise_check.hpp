// SPDX-License-Identifier: Apache-2.0
// Is the twin as noisy as the rig? The redundancy of the real phase steps against the twin's sensor model.
#pragma once
#include <optional>
#include <vector>

#include "compare/result/rows.hpp"
#include "measure/decode/decode.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Variance of a gray value of this level: the sensor's model and the rounding to whole values.
double sensor_variance_dn2(const Sensor& sensor, double dn);

/// One camera: `real` are its images in sequence order, `decode` what `used_steps` (empty = all) of them
/// gave. Nothing for a direction with fewer than four steps, of irradiance images, or with too few values.
std::vector<NoiseRow> noise_rows(const Camera& camera, const Fringes& fringes, const CameraImages& real,
                                 const measure::CameraDecode& decode, const std::vector<int>& used_steps);

}  // namespace fringetwin::compare
