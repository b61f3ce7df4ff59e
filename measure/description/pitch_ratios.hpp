// SPDX-License-Identifier: Apache-2.0
// Tells from wrapped phases how the pitches of a direction stand to each other, whatever the scene is, and
// whether that is what [fringes] says (docs/metrics/measure.md, "Doubts about the description").
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "measure/decode/decode_types.hpp"

namespace fringetwin::measure {

/// Holds the pitches as the phases say them, on the scale on which most of the stated ones are right; 0 where
/// a pitch is too wide to tell.
struct PitchRatios {
  std::vector<double> pitches_px;
  double worst = 0.0;  ///< largest relative difference from what is stated
  double sigma = 0.0;  ///< its standard error, by the scatter of parts of the image
  /// Fringes of the widest pitch that is told, on average of the runs of pixels that tell it: harmonics move
  /// the ends of each run, the more relative to it the shorter it is.
  double turns_per_run = 0.0;
};

/// Returns what the phases of a direction say of its pitches; nothing with less than two that are told, or
/// where there are too few lines of pixels without an edge.
std::optional<PitchRatios> pitch_ratios(const DirectionDecode& decoded);

/// Returns a sentence where the phases contradict the stated pitches beyond their noise; none where these are
/// right in another order, which readings of the images tell.
std::optional<std::string> pitch_doubt(const DirectionDecode& decoded);

}  // namespace fringetwin::measure
