// SPDX-License-Identifier: Apache-2.0
// Turns a twin, a camera and a sampling rule into what the shaders read besides geometry: the block of
// parameters, the specialisation constants that switch code off, and the table of samples.
#pragma once
#include <cstdint>
#include <vector>

#include "render/base/kernels.hpp"
#include "render/base/sampling.hpp"
#include "render/pattern/pattern_plan.hpp"
#include "render/trace/sample_table.hpp"
#include "render/trace/trace_job.hpp"

namespace fringetwin::render {

/// The projector as the shaders see it; `table` only for lenses without a closed form.
struct ProjectorSetup {
  int kind = PROJECTOR_PINHOLE;
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;
  ProjectorTable table;
};
/// Chooses the closed form of the projector's lens, or tabulates a lens that has none.
ProjectorSetup setup_projector(const Projector& projector);

/// The samples of a pixel: their table, or what the shader needs to draw them.
struct SampleSetup {
  int kind = SAMPLER_TABLE;
  std::uint32_t n = 0;  ///< iterations of the sample loop
  Factors factors{1, 1};
  std::vector<gpu::vec4> table;
  std::vector<gpu::uvec4> sobol;
};
/// Sets up the samples of a fixed rule over the pixel's square and, with depth of field, the lens disk; warns
/// when the lens cannot be sampled densely enough for the defocus in view.
SampleSetup setup_samples(const Twin& twin, const Camera& camera, const PackedScene& scene,
                          const Sampling& sampling);

/// The limits per pixel to which the adaptive kernels work.
struct AdaptiveTargets {
  double phase_rad = 0.0;
  double irradiance = 0.0;   ///< for a pattern of full modulation
  int gauss_order = 0;       ///< of the rule that stands in for the closed form, 0: the closed form is used
  std::uint32_t panels = 1;  ///< of LINES_PER_PANEL scan lines each, per mixed pixel
  std::uint32_t stretches = 1;  ///< of a scan line, each with an invocation of its own
};
/// Writes these limits and the image's size into the parameters.
void set_adaptive(const TraceJob& job, const AdaptiveTargets& targets, ParamsBlock* block);

/// Returns the uniform block of one pass, the limits of the adaptive kernels left out.
ParamsBlock make_params(const TraceJob& job, const SampleSetup& samples, const PassPlan& pass);

/// Returns the constants by which a kernel is specialised to the job's scene and lenses, samples and pass.
SpecConstants make_constants(const TraceJob& job, const SampleSetup& samples, const PassPlan& pass);

}  // namespace fringetwin::render
