// SPDX-License-Identifier: Apache-2.0
// Writes the measurement of one capture set as one HTML page with its maps as image files beside it.
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "compare/result/provenance.hpp"
#include "measure/measurement.hpp"

namespace fringetwin::compare {

/// Writes DIR/report.html: fits with their standard errors, what was masked and why, phase, modulation and
/// noise of each camera, deviations from the fits. Maps at full resolution: pixels_<camera>.png,
/// phase_<camera>_<direction>.png, modulation_…, phase_sigma_…, deviation_<object>_measured.png. `captures`:
/// the folder that was measured; empty where there is none.
void write_measurement_page(const std::filesystem::path& dir, const Twin& twin,
                            const measure::Measurement& measurement, const std::filesystem::path& captures,
                            const Provenance& provenance, const std::map<std::string, double>& timing_s);

}  // namespace fringetwin::compare
