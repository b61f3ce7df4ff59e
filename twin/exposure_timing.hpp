// SPDX-License-Identifier: Apache-2.0
// When the exposures of a camera begin and end beside the patterns that are shown: late or early ones, short
// ones, rows that are read out one after the other (docs/PHYSICS.md, "Timing of exposures"). Times are in
// units of the time from one image of the sequence to the next; a pattern is shown from 0 to 1 of its own.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace fringetwin {

/// Where the rows of an image lie on the sensor: the middle of row y at first + step * y, from -1/2 at the
/// sensor's upper border to 1/2 at its lower one.
struct RowHeights {
  double first = 0.0, step = 0.0;
  double of(double y_px) const { return first + step * y_px; }
  /// Returns those of an image whose row y is row first_px + stride * y of this one.
  RowHeights part(double first_px, double stride) const { return {of(first_px), step * stride}; }
};

struct ExposureTiming {
  double exposure = 1.0;          ///< how long each row is exposed
  double read_out = 0.0;          ///< how much later the sensor's lower border begins than its upper one
  std::vector<double> late = {};  ///< of each image, or one number of all; empty: 0
  /// Of an image that is a part of the camera's own, every k-th of its pixels say; else the camera tells.
  std::optional<RowHeights> rows = {};

  double late_of(std::size_t image) const {
    if (late.empty()) return 0.0;
    return late.size() == 1 ? late.front() : late.at(image);
  }
  /// Returns when the exposure of a row begins after the pattern of its image does; negative: before.
  double begin(std::size_t image, double height) const { return late_of(image) + read_out * height; }
  /// Returns when the middle of the exposure of the middle row is after that of its pattern.
  double middle(std::size_t image) const { return late_of(image) + 0.5 * (exposure - 1.0); }
};

/// What an exposure sees of the pattern before its own, of its own and of the one after.
struct ExposureParts {
  std::array<double, 3> share{};   ///< of the exposure; together 1
  std::array<double, 3> middle{};  ///< of the time of this part, after the begin of the own pattern
};

/// Returns the parts of an exposure of this length that begins so much after its pattern does.
inline ExposureParts exposure_parts(double begin, double exposure) {
  const double end = begin + exposure;
  const std::array<double, 4> borders{begin, std::clamp(0.0, begin, end), std::clamp(1.0, begin, end), end};
  ExposureParts parts;
  for (std::size_t k = 0; k < 3; ++k) {
    parts.share[k] = (borders[k + 1] - borders[k]) / exposure;
    parts.middle[k] = 0.5 * (borders[k] + borders[k + 1]);
  }
  return parts;
}

/// Returns whether some row of an image sees another pattern than its own.
inline bool sees_neighbours(const ExposureTiming& timing, std::size_t image) {
  const double reach = 0.5 * timing.read_out;
  return timing.late_of(image) - reach < 0.0 || timing.late_of(image) + reach + timing.exposure > 1.0;
}

}  // namespace fringetwin
