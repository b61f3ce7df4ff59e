// SPDX-License-Identifier: Apache-2.0
// Fits a twin to some phase steps of the real images and says how well it predicts the others, which took no
// part in that (docs/metrics/gray.md, "Held-out images").
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "compare/result/held_out_table.hpp"
#include "compare/result/options.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

/// Phase steps that are predicted, and those that are fitted for it; of whole pitches, and of the bits of a
/// sequence without phase steps, their images.
struct Fold {
  std::vector<int> held_out, fitted;                  ///< phase steps
  std::vector<int> held_out_images, fitted_images{};  ///< of the sequence: of pitches, or of a code
};

/// Deals the steps to so many folds in turn: step n is held out with fold n mod n_folds. Throws
/// UserError(usage) where less than two folds are asked for, more than there are steps, or where a fold
/// leaves fewer than 3 steps to fit, which a phase needs.
std::vector<Fold> folds_of(int steps, int n_folds);

/// Deals the phase steps, or the pitches, or of a code alone its bits, those of both directions one after the
/// other: the images of a bit (the pattern and its inverse) or of a pitch stay together. Throws as above, and
/// where there are fewer bits or pitches than folds.
std::vector<Fold> folds_of(const Fringes& fringes, int n_folds, HeldOutBy by = HeldOutBy::steps);

/// What the images of one fold are predicted from.
struct HeldOutInput {
  const Twin& twin;  ///< as written; of a measured object, its shape from the fitted steps alone
  const std::vector<CameraImages>& real;
  const Side& simulated;  ///< the twin, rendered and measured
  const CompareOptions& options;
  const std::vector<std::string>& asked;  ///< what is fitted: as `--refine`; empty: gain and black level
  const Fold& fold;
  /// Share of a gray value's variance that the shape has from each fitted step: 0 where no object is
  /// measured, else SurfaceNoise::leverage (measure/surface_noise.hpp); by the noise of the phases, which
  /// counts that of shapes of two cameras as if the projector were one of them.
  double shape_leverage = 0.0;
};

/// What one fold is predicted to.
struct HeldOut {
  std::vector<HeldOutRow> rows;   ///< of each camera and image, without the number of the fold
  std::vector<HeldOutMap> worst;  ///< of each camera
};

/// Predicts the images of a fold that are held out. Everything is
/// decoded, fitted and chosen by the fitted steps (and the images of a code; all bits of a code alone, and
/// all pitches, say which pixels are compared, but none that is held out is fitted to); of a held-out image
/// only its factors of light and exposure are taken from itself, with "light" and "exposure" alone. A fit
/// counts as it is: nothing is taken back. Throws as refine().
HeldOut predict_held_out(const HeldOutInput& input);

/// Keeps the worse of two maps of each camera.
void keep_worst(std::vector<HeldOutMap>& of_cameras, std::vector<HeldOutMap> others);

/// Returns the root of the mean square of what is left over that of what is predicted, of all rows of a
/// camera; NaN without rows.
double held_out_ratio(const std::vector<HeldOutRow>& rows, const std::string& camera);

/// Returns a sentence per camera with that ratio and those of its images.
std::vector<std::string> held_out_sentences(const std::vector<HeldOutRow>& rows);

}  // namespace fringetwin::compare
