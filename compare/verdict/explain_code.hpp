// SPDX-License-Identifier: Apache-2.0
// Judges the images of a Gray code that is shown beside phase steps: are they lit and spread as the twin
// says? (docs/metrics/verdict.md, "Images of a code"). Where the fringes lie is the verdict on the phase:
// what their difference moves the edges of the code by is in the budget, not held against it.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/verdict/explained.hpp"

namespace fringetwin::compare {

/// Light of an image of a code that is worth telling: less moves no bit, and is what gain and rendering may
/// be off by.
inline constexpr double kLeastOtherLight = 0.005;

/// The light of one image of a code, over what the twin says of it.
struct CodeLight {
  int image = 0;        ///< of the sequence
  double factor = 1.0;  ///< of all its light, the room's too
  double sigma = 0.0;   ///< standard error by the noise of its gray values
};

/// What a verdict on the images of a code says: one row, and what was taken out of each image before.
struct CodeVerdict {
  ExplainedRow row;
  std::vector<CodeLight> lights;
};

/// Holds what a camera's code is judged with beside its gray values.
struct CodeInView {
  const measure::CameraDecode& real;
  const measure::CameraDecode& simulated;
  const ImageU8& interior;
  const PixelTexture* texture = nullptr;  ///< of the twin's camera; may be null
  double pixel_side_px = 1.0;             ///< of the sensor's pixels, px of the image
};

/// Judges the gray values of all images of a code over the interior pixels, each image with a factor of its
/// own light. Returns nothing where there is no code beside phase steps, or too few values to judge.
/// `noise`, `rendering`, `own` and `shape` are those of explain_gray().
std::optional<CodeVerdict> explain_code(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                                        const CodeInView& code, const RenderingError& rendering,
                                        const OwnOfPixels& own = {}, const ShapeInView& shape = {});

/// Returns what a reader must know of a code whose images have other light than the twin says; empty where
/// they have not.
std::string light_text(const CodeVerdict& code, const GrayPair& pair, const Fringes& fringes);

}  // namespace fringetwin::compare
