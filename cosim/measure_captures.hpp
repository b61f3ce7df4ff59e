// SPDX-License-Identifier: Apache-2.0
// Measures one capture set alone: a twin and its images become phases, points and fits, and their files.
#pragma once
#include <filesystem>
#include <vector>

#include "cosim/write_results.hpp"
#include "measure/measurement.hpp"
#include "twin/base/stopwatch.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// Returns whether the twin is rendered when a capture set is measured: where its method's bias is asked for,
/// here or in the twin. Throws UserError(usage) where it cannot be.
bool measuring_renders(const Twin& twin, bool method_bias);

/// Measures the images (order of twin.cameras), states the method's bias where measuring_renders() says so,
/// and adds to the warnings what the images say against the description of the fringes.
measure::Measurement measure_captures(const Twin& twin, const std::vector<CameraImages>& images,
                                      bool method_bias, StageTimer& timer);

/// Writes DIR/points.ply, DIR/deviation_<object>.ply, DIR/phase_<camera>.exr, DIR/report.html with its maps
/// and, last, DIR/result.json.
/// `capture_files`: what was read besides the twin's own files; `extra`: what is asked for besides.
void write_measured(const std::filesystem::path& dir, const Twin& twin,
                    const measure::Measurement& measurement,
                    const std::vector<std::filesystem::path>& capture_files, const Origin& origin,
                    StageTimer& timer, const ExtraFiles& extra = {});

}  // namespace fringetwin::cosim
