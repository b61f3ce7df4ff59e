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

/// Holds what a comparison knows of one side.
struct Side {
  std::vector<CameraImages> images;  ///< order of twin.cameras; empty when only published numbers are known
  /// Of the simulated side perhaps without amplitudes but those of the finest pitch, which all comparisons
  /// ask for; those of the others are empty then.
  std::optional<measure::Measurement> measurement;
  /// Irradiance images of the simulated side, before the sensor, in the order of the sequence; empty where
  /// neither the renderer nor EXR files gave them.
  std::vector<CameraImages> irradiance;
};

/// Returns a side's decode of one camera; null where the side was not measured.
inline const measure::CameraDecode* decode_of(const Side& side, std::size_t camera) {
  return side.measurement && camera < side.measurement->cameras.size() ? &side.measurement->cameras[camera]
                                                                       : nullptr;
}

}  // namespace fringetwin::compare
