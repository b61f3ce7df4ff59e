// SPDX-License-Identifier: Apache-2.0
// Plans which sums one trace collects: a cosine and a sine per pitch and harmonic, and the images that are
// evaluated directly; split into passes when they are more than one shader holds.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/base/split_float.hpp"
#include "render/pattern/response_series.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// One cosine/sine pair of a pass.
struct PitchSlot {
  std::size_t direction, pitch;
  int harmonic;    ///< 1, then 2, 3 ... of the same pitch in the slots that follow
  Double4 values;  ///< Params::pitch
  /// Size of the harmonic in the light that arrives, of the fundamental's: what an error of it counts.
  double share = 1.0;
};
/// One image that the trace evaluates directly, with the table from which it does.
struct DirectSlot {
  enum class Kind { periodic, axis, pixel, gray, image };
  Kind kind;
  std::size_t image;  ///< index in the sequence
  Double4 a{}, b{};   ///< Params::direct, direct_b
  std::vector<float> waveform;
};
/// The sums of one pass over all pixels.
struct PassPlan {
  std::vector<PitchSlot> pitches;
  std::vector<float> gaps;         ///< gap_waveform(), empty without blurred gaps; first of the pass's tables
  std::vector<DirectSlot> direct;  ///< periodic, then axis, pixel, gray, image
  int count(DirectSlot::Kind kind) const;
  std::size_t table_size() const;      ///< samples of all tables together
  std::uint32_t fundamentals() const;  ///< bit i: pitches[i] is a fundamental
  std::size_t channels() const { return 2 + 2 * pitches.size() + direct.size(); }
  PassPlan without_harmonics() const;
};

/// Returns the passes, at least one. `center_x_px`, `center_y_px`: the projector's principal point, from
/// which the shaders measure. `series`: choose_series() of the twin; an empty one means that each step is
/// evaluated directly. Throws UserError(usage) for combinations of projector effects that no trace can
/// render, and for tables that are too large.
/// `most_pairs`: of a pass, MAX_PITCHES at most.
std::vector<PassPlan> plan_passes(const Twin& twin, const SeriesTable& series, double center_x_px,
                                  double center_y_px, std::size_t most_pairs = kMostPairs);

}  // namespace fringetwin::render
