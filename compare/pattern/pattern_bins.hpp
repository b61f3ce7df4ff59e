// SPDX-License-Identifier: Apache-2.0
// Sorts gray values by their coordinates into bins, and into parts that are predicted from one another.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "compare/pattern/left_values.hpp"

namespace fringetwin::compare {

/// Places of coordinates in their order (gray level, phase, image, radius, place, …); from kPhaseByPlace on
/// those that hold the phase and another one.
constexpr std::size_t kPhase = 1, kImageNumber = 2, kPlace = 4, kPhaseByPlace = 5, kPhaseByImage = 6;
constexpr int kPatternBins = 256;  ///< of gray level, phase and radius: 24 steps of a projector are seen
constexpr int kPhaseBins = 32;     ///< of the phase in each cell or image: a seventh harmonic is seen
constexpr int kPatternParts = 4;   ///< of the image or the sequence: one is predicted from the others

/// The values of one camera, sorted into bins.
struct Bins {
  std::vector<int> of;           ///< of each value; -1: none
  std::vector<double> at, at_y;  ///< of each bin; at_y: of a place, and the number of a cell or image
};

/// Returns the bins of a coordinate: equally many values (gray level, radius), equal parts (phase, place),
/// one of each image. Where the phase and another one are held, kPhaseBins in a row are of one cell or image.
Bins bins_of(std::size_t coordinate, const LeftOver& camera);

/// Returns the quarter of the camera's values that each lies in: the medians of x, and of y on either side.
std::vector<std::uint8_t> quarters_of_image(const std::vector<LeftValue>& values);
/// Returns the quarter of the camera's values that each lies in, side by side along x or y.
std::vector<std::uint8_t> strips_of_image(const std::vector<LeftValue>& values, float LeftValue::*along);
/// Returns the quarter of the images, in their order, that each value is of.
std::vector<std::uint8_t> quarters_of_sequence(const std::vector<LeftValue>& values);
/// Returns a number of each value's pixel, the same for all images of it.
std::vector<int> numbers_of_pixels(const std::vector<LeftValue>& values);

}  // namespace fringetwin::compare
