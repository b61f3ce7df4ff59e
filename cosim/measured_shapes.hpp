// SPDX-License-Identifier: Apache-2.0
// Builds the objects with shape = "measured" from the real captures of the scene they stand in.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// True when an object's shape is to be built from the real capture.
bool has_measured_shape(const Twin& twin);

/// Throws UserError(usage) when an object is to be built from real captures and the twin names none.
void check_measured_shapes(const Twin& twin);

/// Replaces every MeasuredShape by the surface measured from `real`. The steps a comparison may use then:
/// left_over_steps() (twin/captures/measured_steps.hpp), to be asked before.
void build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real);
/// The same from these phase steps instead of those that the objects name.
void build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real, const std::vector<int>& steps);
/// Returns the largest smoothing_leverage() (measure/surface.hpp) of the measured shapes; 0 without one.
double measured_shape_leverage(const Twin& twin);

/// Reads a twin with everything a renderer needs: its meshes, and measured shapes built from the captures
/// that [real] names. `settings`: as load_for_run() takes them.
Twin load_renderable_twin(const std::filesystem::path& file,
                          const std::map<std::string, std::string>& settings = {});

}  // namespace fringetwin::cosim
