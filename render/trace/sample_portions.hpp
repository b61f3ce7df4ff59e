// SPDX-License-Identifier: Apache-2.0
// Runs a kernel for many samples in portions that the driver does not cut short. Internal to render/
// (includes volk).
#pragma once
#include <cstdint>

#include "render/trace/trace_device.hpp"

namespace fringetwin::render {

/// Sums samples 0 ... n - 1 of some work groups, `*at_a_time` in one dispatch: fewer from now on where the
/// driver's limit of loop iterations cuts an invocation short. The ray through the middle of a pixel
/// (push.n_centre) belongs to the first of them. Throws UserError(device) where a single sample is too much.
void run_in_portions(TraceDevice& device, ComputePipeline& kernel, gpu::Push push, std::uint32_t n,
                     std::uint32_t groups, std::uint32_t* at_a_time, Transport* out);

/// Says that a single ray is cut short.
[[noreturn]] void throw_ray_cut_short(const TraceDevice& device);

}  // namespace fringetwin::render
