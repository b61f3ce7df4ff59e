// SPDX-License-Identifier: Apache-2.0
// Holds one of the two sides of a comparison, the real or the simulated one: its images, what was measured
// from them, and the irradiance where that is known.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "measure/measurement.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::compare {

/// What a comparison knows of one side.
struct Side {
  std::vector<CameraImages> images;  ///< order of twin.cameras; empty = published numbers only
  std::optional<measure::Measurement> measurement;
  /// Irradiance of the simulated side where known (renderer or EXR), sequence order; may be empty.
  std::vector<CameraImages> irradiance;
};

/// A side's decode of one camera; null where it was not measured.
inline const measure::CameraDecode* decode_of(const Side& side, std::size_t camera) {
  return side.measurement ? &side.measurement->cameras.at(camera) : nullptr;
}

}  // namespace fringetwin::compare
