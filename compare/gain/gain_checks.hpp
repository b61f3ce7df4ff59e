// SPDX-License-Identifier: Apache-2.0
// Fits the line of the gain once more on parts of the gray values: within and between the pixels, on halves
// of the image, on the dark and the bright half, step by step and pitch by pitch. A gain that is the sensor's
// is the same on all of them (docs/metrics/gray.md, "Gain checks").
#pragma once
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_noise.hpp"

namespace fringetwin::compare {

inline constexpr const char* kAllValues = "all values";
inline constexpr const char* kWithinPixels = "within pixels";
inline constexpr const char* kBetweenPixels = "between pixels";
inline constexpr const char* kLowValues = "values below the pixel's mean";
inline constexpr const char* kHighValues = "values above the pixel's mean";

/// What the parts say.
struct GainParts {
  std::vector<GainCheck> rows;     ///< the first is of all values; empty where there are too few
  double dropped_fraction = kNaN;  ///< share of the values that only the margins of the fit left out
};

/// Fits all parts by least squares, weighted with the predicted noise, on at most 60,000 pixels of
/// `interior`, evenly spread. Standard errors: sandwich over blocks of 32x32 pixels, never below the
/// predicted noise. Gray values near a clip are left out by that noise, not by the residuals of the fit:
/// these follow the prediction, and what is chosen by a wrong one agrees with it. The result does not depend
/// on the number of threads.
GainParts gain_checks(const Fringes& fringes, const GrayPair& pair, const GainFit& fit,
                      const GrayNoise& noise, const ImageU8& interior);

}  // namespace fringetwin::compare
