// SPDX-License-Identifier: Apache-2.0
// Which sums one trace collects: cosine/sine per pitch, and images evaluated directly; split into
// passes when they are more than one shader holds.
#pragma once
#include <cstddef>
#include <vector>

#include "render/split_float.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

struct PitchSlot {
  std::size_t direction, pitch;
  Double4 values;  ///< Params::pitch
};
struct DirectSlot {
  enum class Kind { periodic, axis, gray, image };
  Kind kind;
  std::size_t image;  ///< index in the sequence
  Double4 a{}, b{};   ///< Params::direct, direct_b
  std::vector<float> waveform;
};
struct PassPlan {
  std::vector<PitchSlot> pitches;
  std::vector<DirectSlot> direct;  ///< periodic, then axis, gray, image
  int count(DirectSlot::Kind kind) const;
  std::size_t channels() const { return 2 + 2 * pitches.size() + direct.size(); }
};

/// At least one pass. `center_px`: the projector's principal point, from which the shaders measure.
std::vector<PassPlan> plan_passes(const Twin& twin, double center_x_px, double center_y_px);

}  // namespace fringetwin::render
