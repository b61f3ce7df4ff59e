// SPDX-License-Identifier: Apache-2.0
// The images of a Transport that the passes fill.
#pragma once
#include <vector>

#include "render/base/transport.hpp"
#include "render/pattern/pattern_plan.hpp"

namespace fringetwin::render {

Transport empty_transport(const Twin& twin, const std::vector<PassPlan>& passes, const SeriesTable& series,
                          int width, int height);

struct PairImages {
  ImageF *cosine, *sine;
};
PairImages pair_images(Transport* transport, const PitchSlot& slot);

/// All of this size and 0. Touching so much memory for the first time is worth several threads.
void make_blank(const std::vector<ImageF*>& images, int width, int height);

}  // namespace fringetwin::render
