// SPDX-License-Identifier: Apache-2.0
// Traces a camera by a fixed rule: the same samples in every pixel that may see an object.
#pragma once
#include <vector>

#include "render/trace/trace_device.hpp"

namespace fringetwin::render {

/// Traces all passes by the rule that job.out->sampling names and fills job.out; shows a progress bar where
/// that takes long. The scene must have been uploaded.
void trace_by_fixed_rule(TraceDevice& device, const TraceJob& job, const std::vector<PassPlan>& passes);

}  // namespace fringetwin::render
