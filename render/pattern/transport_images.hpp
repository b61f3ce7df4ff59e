// SPDX-License-Identifier: Apache-2.0
// Prepares the images of a Transport that the passes of a trace fill.
#pragma once
#include <vector>

#include "render/base/transport.hpp"
#include "render/pattern/pattern_plan.hpp"

namespace fringetwin::render {

/// Returns a transport with all images that the passes fill, of this size and 0, and no object anywhere.
Transport empty_transport(const Twin& twin, const std::vector<PassPlan>& passes, const SeriesTable& series,
                          int width, int height);

struct PairImages {
  ImageF *cosine, *sine;
};
/// Returns the images of a transport into which a cosine/sine pair goes.
PairImages pair_images(Transport* transport, const PitchSlot& slot);

/// Makes all images of this size and 0. Touching so much memory for the first time is worth several threads.
void make_blank(const std::vector<ImageF*>& images, int width, int height);

}  // namespace fringetwin::render
