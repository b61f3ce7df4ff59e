// SPDX-License-Identifier: Apache-2.0
// Computes by how much the simulated image would have to move to lie on the real one, block by block: a
// diagnosis of the calibration (docs/metrics/phase.md, "Shift field").
#pragma once
#include <optional>

#include "compare/gray/gain_fit.hpp"

namespace fringetwin::compare {

/// Variance of a real gray value over its level.
struct NoiseLine {
  double offset_dn2 = 0.0, per_dn = 0.0, least_dn2 = 0.0;
  double variance_dn2(double dn) const {
    const double v = offset_dn2 + per_dn * dn;
    return v > least_dn2 ? v : least_dn2;
  }
};
/// Returns the noise line of the gray budget where there is one, else of the twin's sensor; of irradiance the
/// scatter of the gain fit.
NoiseLine noise_line(const GrayPair& pair, const GainFit& fit, const std::optional<GrayBudget>& budget);

/// Fits the shifts by least squares of the gray residual of all phase steps on the image gradients. Each
/// pixel's own brightness is taken out first, so albedo and shading neither make a shift nor show one: only
/// the fringes do.
ShiftRow shift_field(const GrayPair& pair, const GainFit& fit, const NoiseLine& noise);

}  // namespace fringetwin::compare
