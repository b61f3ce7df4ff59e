// SPDX-License-Identifier: Apache-2.0
// Carries what the kernels summed up, channel by channel, into the images of a Transport.
#pragma once
#include <cstddef>
#include <vector>

#include "render/pattern/pattern_plan.hpp"
#include "render/trace/trace_job.hpp"

namespace fringetwin::render {

/// The place of one output channel's sums: an image (nullptr: not kept), and the factor that they get.
struct SumTarget {
  ImageF* image;
  float factor;
};
/// Returns the targets of a pass in the order of its output channels. Mean and ambient are kept of the first
/// pass only; the others sum up the same.
std::vector<SumTarget> sum_targets(const Twin& twin, const PassPlan& pass, bool first_pass, Transport* out);

/// Writes the sums of the n blocks from job.blocks[first] on, [channel][block][pixel], into their targets.
void scatter_sums(const TraceJob& job, const std::vector<SumTarget>& targets, std::size_t first,
                  std::size_t n, const float* sums);

}  // namespace fringetwin::render
