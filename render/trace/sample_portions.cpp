// SPDX-License-Identifier: Apache-2.0
#include "render/trace/sample_portions.hpp"

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::render {

void run_in_portions(TraceDevice& device, ComputePipeline& kernel, gpu::Push push, std::uint32_t n,
                     std::uint32_t groups, std::uint32_t* at_a_time, Transport* out) {
  const gpu::uint n_centre = push.n_centre;
  const std::uint64_t rays_before = out->rays;
  for (std::uint32_t first = 0; first < n;) {
    push.first_sample = first;
    push.end_sample = std::min(n, first + *at_a_time);
    push.resume = first > 0;
    push.n_centre = first == 0 ? n_centre : 0;
    if (device.dispatch(kernel, push, groups, out)) {
      first = push.end_sample;
      continue;
    }
    // Some invocation was cut short, and its sums are wrong: begin again in smaller portions.
    if (*at_a_time == 1) throw_ray_cut_short(device);
    *at_a_time = std::max(1U, std::min(*at_a_time, n) / 2);
    ++out->repeated_dispatches;
    out->rays = rays_before;
    first = 0;
  }
}

void throw_ray_cut_short(const TraceDevice& device) {
  throw UserError(ExitCode::device, device.vulkan().info().name,
                  "a single ray exceeds the driver's limit of loop iterations",
                  "use a newer driver (Mesa 25 has no such limit) or split the mesh");
}

}  // namespace fringetwin::render
