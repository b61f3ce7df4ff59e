// SPDX-License-Identifier: Apache-2.0
// Builds from made sides what a comparison holds of the first camera before it judges gray values: the pair
// of image sets, both decodes, the noise of the real gray values and the fitted gain; besides, truths of 12
// bit that several tests start from.
#pragma once
#include <string>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_noise.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::testing {

/// Returns the truth of a 12 bit camera of 200 DN whose 4 DN of noise are far more than rounding; its black
/// level stands above the clip, so that all values are usable.
SidesTruth deep_truth(double black_level_dn = 400.0);
/// Returns that of eight steps of 16 px beside a code of five bits.
SidesTruth coded_truth(double black_level_dn = 60.0);
/// Returns the truth of a 12 bit camera of 280 DN, black level 64 DN and 9 DN of noise, whose twin believes
/// in 300 DN and no black level.
SidesTruth misjudged_truth();

/// Returns the pair of the first camera. It points into the sides, which must outlive it.
compare::GrayPair gray_pair(const SyntheticSides& sides);

/// Says where the gain fit takes its distance from the clips from.
enum class Margins { residuals, noise };

/// Holds the made sides with all that points into them: it is neither copied nor moved.
struct FittedGray {
  explicit FittedGray(SyntheticSides made, Margins margins = Margins::residuals);
  FittedGray(const FittedGray&) = delete;
  FittedGray& operator=(const FittedGray&) = delete;

  const measure::CameraDecode* real_decode() const { return compare::decode_of(sides.real, 0); }
  const measure::CameraDecode* simulated_decode() const { return compare::decode_of(sides.simulated, 0); }
  /// Returns the noise of the real gray values, from all of their phase steps.
  compare::GrayNoise noise() const { return {pair, real_decode(), {}}; }

  SyntheticSides sides;
  std::vector<std::string> warnings;  ///< of the pairing and of the fit
  compare::GrayPair pair;
  compare::GainFit fit;
};

}  // namespace fringetwin::testing
