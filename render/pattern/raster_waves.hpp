// SPDX-License-Identifier: Apache-2.0
// Traces and adds the waves that single orders of the shown levels make with the projector's pixels
// (docs/PHYSICS.md, "Fringes that are no sinusoids"). To the trace each is a fringe of its own, so that a
// second trace has their sums, with targets as coarse as the waves are small.
#pragma once
#include <vector>

#include "render/base/sampling.hpp"
#include "render/base/transport.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// A wave of the raster without its step: 2 pi turns (x - origin)/pitch + ahead, origin and pitch of the
/// fringes, where the light lands at x.
struct RasterWave {
  int order;
  double turns;  ///< per fringe; negative ones run backwards
  double ahead_rad;
};
/// Returns the `wave`-th of those that a direction's raster has of a pitch.
RasterWave raster_wave(const Twin& twin, const DirectionFringes& direction, std::size_t pitch,
                       std::size_t wave);

/// Returns a twin whose fringes are the waves: a direction with a pitch per wave that is there for each pitch
/// of each of the twin's directions that have any, in their order.
Twin showing_waves(const Twin& twin);

/// Returns the targets of that trace: an error of a wave counts as much as the wave.
Sampling sampling_of_waves(const Twin& twin, const Sampling& sampling);

/// Takes the sums of the trace `seen` of showing_waves() into the transport of the twin, with its rays and
/// what its errors add to the estimate.
void take_waves(const Twin& twin, Transport seen, Transport& transport);

/// What a wave brings to an image: cosine C - sine S, C and S its sums in the transport.
struct WaveTerm {
  std::size_t wave;
  double cosine, sine;
};
/// Returns the terms of a phase step of the sequence, without the light factors of the image.
std::vector<WaveTerm> waves_of_image(const Twin& twin, const PatternSpec& spec, std::size_t image);

}  // namespace fringetwin::render
