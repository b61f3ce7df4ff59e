// SPDX-License-Identifier: Apache-2.0
// Says how well a reading of a camera's images fits: how many of the pixels that the fringes reach it decodes
// without a contradiction.
#pragma once
#include "measure/decode/decode_types.hpp"
#include "measure/description/reading.hpp"

namespace fringetwin::measure {

/// Projector coordinates that a rendered twin expects, NaN where it has none; empty where nothing is
/// expected.
struct ExpectedCoordinates {
  ImageD x_px, y_px;
  const ImageD& along(Axis axis) const { return axis == Axis::x ? x_px : y_px; }
};

struct ReadingScore {
  std::uint64_t n = 0;    ///< pixels that the fringes reach
  double valid = 0.0;     ///< share of them with a coordinate in every direction
  double jumps = 0.0;     ///< order errors that the repair leaves, per valid pixel
  double residual = 0.0;  ///< median over the pixels of the largest residual of a pitch's steps over its
                          ///< amplitude; 0 for N = 3
  /// Of the pixels that are expected somewhere: share decoded less than a period of the finest fringe from
  /// there, median distance in periods with its sign, and median distance from that median. NaN: not known.
  double near = 0.0, offset = 0.0, scatter = 0.0;
  /// Share of the pixels that no contradiction speaks against.
  double good = 0.0;
};

/// Decodes `images` (small ones: tiles.hpp) as the reading says and counts over the pixels that the fringes
/// reach (reached_pixels(), the same for every reading).
ReadingScore score_reading(const CameraImages& images, const ImageU8& reached, const Reading& reading,
                           const DecodeOptions& options, const ExpectedCoordinates& expected);

}  // namespace fringetwin::measure
