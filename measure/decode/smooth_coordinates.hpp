// SPDX-License-Identifier: Apache-2.0
// Reduces the noise of decoded coordinates by local quadratic least squares.
#pragma once
#include "measure/decode/decode_types.hpp"

namespace fringetwin::measure {

/// Replaces each valid coordinate by the value at its pixel of a quadratic fitted to the valid pixels
/// within radius_px (at least 10 of them), and its sigma by what the fit leaves of it. Pixels whose
/// neighbourhood the noise does not explain (a residual beyond 5 sigma: steps, edges, rims) keep
/// their raw value. Nothing happens where no sigma is known. The wrapped phases stay raw.
/// Neighbouring points then share noise: standard errors of fits, which count points as independent,
/// come out too small by up to 1/(noise factor) of the window.
void smooth_coordinates(CameraDecode& decode, double radius_px);

}  // namespace fringetwin::measure
