// SPDX-License-Identifier: Apache-2.0
// Makes what a camera's exposures see out of the images that each pattern alone gives: row by row a mean of
// the patterns that a row's exposure reaches into (docs/PHYSICS.md, "Timing of exposures").
#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "twin/exposure_timing.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Images `first` ... `first + count - 1` of a sequence.
struct ImageRange {
  std::size_t first = 0, count = 0;
};
/// Returns these images and those beside them. Before the first and after the last there is none.
ImageRange with_neighbours(ImageRange range, std::size_t n_images);

/// The patterns that the exposure of an image may see: the one before, its own, and the one after.
using SeenPatterns = std::array<const ImageF*, 3>;
/// Returns those of an image among the images of a range. The first image of the sequence is its own one
/// before, the last its own one after.
SeenPatterns seen_patterns(std::span<const ImageF> images, ImageRange range, std::size_t image);

/// Returns whether an exposure of these images sees another pattern than its own.
bool mixes_patterns(const Camera& camera, ImageRange range);

/// Returns what the exposure of an image sees of the patterns, nothing moving, with its exposure factor.
ImageF exposed(const Camera& camera, std::size_t image, const SeenPatterns& patterns);

/// When an exposure is to be seen whose objects move: two times, in image periods after that of the image.
/// Their mean is the middle of the middle row's exposure. The places of rows and parts of an exposure lie on
/// the straight line through both; they are so far apart that the line's mean square is that of all times at
/// which light comes in, but no row's middle lies outside of them: its light is no extrapolation.
struct ExposureTimes {
  double middle = 0.0, apart = 0.0;  ///< middle - apart, middle + apart
};
ExposureTimes exposure_times(const ExposureTiming& timing, std::size_t image);

/// Returns what the exposure of an image sees of the patterns, the objects where they are at the first and at
/// the second of the exposure_times(): linear in time between, with its exposure factor; no light is below 0.
ImageF exposed_moving(const Camera& camera, std::size_t image, const SeenPatterns& earlier,
                      const SeenPatterns& later);

}  // namespace fringetwin::render
