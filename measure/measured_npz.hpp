// SPDX-License-Identifier: Apache-2.0
// Writes what was measured as arrays for numpy (docs/formats/results.md, "Arrays for numpy").
#pragma once
#include <filesystem>
#include <string>

#include "measure/measurement.hpp"

namespace fringetwin::measure {

/// Returns "measured_<camera>.npz".
std::string measured_npz_name(const std::string& camera);

/// Writes DIR/measured_<camera>.npz of each camera: the channels of its phase_<camera>.exr, `flags`
/// (PixelFlag) and `mask` (true where they are 0); of the first camera also the points. DIR exists. Throws
/// Cancelled.
void write_measured_npz(const std::filesystem::path& dir, const Measurement& measurement);

}  // namespace fringetwin::measure
