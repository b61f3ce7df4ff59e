// SPDX-License-Identifier: Apache-2.0
// Writes a comparison as one HTML page with its maps as image files beside it.
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "compare/result/options.hpp"
#include "compare/result/provenance.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"

namespace fringetwin::compare {

/// Writes DIR/report.html and the maps at full resolution (coverage_<camera>.png,
/// gray_difference_<camera>.png, held_out_<camera>.png, phase_difference_<camera>_<direction>.png,
/// deviation_<object>_<side>.png).
/// Sections without data are left out; with no real images the simulated ones are shown and the page says so.
void write_report(const std::filesystem::path& dir, const Twin& twin, const Side& real, const Side& simulated,
                  const Comparison& comparison, const CompareOptions& options, const Provenance& provenance,
                  const std::map<std::string, double>& timing_s);

}  // namespace fringetwin::compare
