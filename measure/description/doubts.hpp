// SPDX-License-Identifier: Apache-2.0
// Says where the images of a camera contradict the description of what was projected, and which other reading
// of them would fit (docs/metrics/measure.md, "Doubts about the description").
#pragma once
#include <string>
#include <vector>

#include "measure/decode/decode_types.hpp"
#include "measure/description/reading_score.hpp"

namespace fringetwin::measure {

/// What a doubt is about. Pitches that are others than stated make wrong fringe orders and coordinates
/// elsewhere, which an origin or another order of the pitches seems to mend; they repeat no image, exchange
/// none and leave no residuals of the phase steps.
enum class DoubtKind { other, explained_by_pitches, repeated_image };

/// Holds what speaks against the description of the images.
struct Doubt {
  std::string sentence;
  /// True where the images show other fringes than described: another reading fits, or an image is missing.
  bool shows_other_fringes = false;
  DoubtKind kind = DoubtKind::other;
};

/// Returns a doubt per contradiction, each beginning with the camera; none where the images are as
/// described. `decoded`: what decode() made of them with `options`. `expected`: of a rendered twin, as large
/// as the images; may be empty, then fewer contradictions can be seen.
std::vector<Doubt> description_doubts(const CameraImages& images, const Fringes& fringes,
                                      const DecodeOptions& options, const CameraDecode& decoded,
                                      const ExpectedCoordinates& expected);

}  // namespace fringetwin::measure
