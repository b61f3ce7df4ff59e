// SPDX-License-Identifier: Apache-2.0
// Builds the objects with shape = "measured" from the real captures of the scene they stand in.
#pragma once
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compare/shape/shape_noise.hpp"
#include "measure/surface.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// True when an object's shape is to be built from the real capture.
bool has_measured_shape(const Twin& twin);

/// Throws UserError(usage) when an object is to be built from real captures and the twin names none.
void check_measured_shapes(const Twin& twin);

/// Replaces every MeasuredShape by the surface measured from `real`, from these phase steps; without any from
/// those that the objects name. What `correct_fringes` takes out is told by these steps alone, too; without
/// any by all. Warnings that are in `told` are not said again, new ones are put there. The steps a comparison
/// may use then: left_over_steps() (twin/captures/measured_steps.hpp), to be asked before. Returns what noise
/// the shapes have, the largest of each kind; nothing without a measured shape.
std::optional<measure::SurfaceNoise> build_measured_shapes(Twin& twin, const std::vector<CameraImages>& real,
                                                           const std::vector<int>& steps = {},
                                                           std::set<std::string>* told = nullptr);

/// Does the same from the steps that the objects name, for a comparison of these steps; without any of all.
/// Returns the noise as the comparison takes it; null without a measured shape.
std::shared_ptr<const compare::ShapeNoise> build_compared_shapes(Twin& twin,
                                                                 const std::vector<CameraImages>& real,
                                                                 const std::vector<int>& compared);

}  // namespace fringetwin::cosim
