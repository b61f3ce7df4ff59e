// SPDX-License-Identifier: Apache-2.0
// Adds the light that comes over other surfaces to what a trace measured of the projector's own light.
// Internal to render/ (includes volk).
#pragma once
#include <vector>

#include "render/pattern/pattern_plan.hpp"
#include "render/trace/trace_device.hpp"

namespace fringetwin::render {

/// Adds [render] bounces to job.out, and its noise to the estimate where that has one. The scene must have
/// been uploaded.
void add_indirect_light(TraceDevice& device, const TraceJob& job, const std::vector<PassPlan>& passes);

}  // namespace fringetwin::render
