// SPDX-License-Identifier: Apache-2.0
// What one trace hands to the shaders besides geometry: parameters, switches, active blocks.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "render/pattern/pattern_plan.hpp"
#include "render/renderer.hpp"
#include "render/scene/scene.hpp"
#include "render/trace/lens_table.hpp"
#include "render/trace/sample_table.hpp"

namespace fringetwin::render {

using SpecConstants = std::array<std::uint32_t, SPEC_COUNT>;

/// Projector as the shaders see it; `table` only for lenses without a closed form.
struct ProjectorSetup {
  int kind = PROJECTOR_PINHOLE;
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;
  ProjectorTable table;
};
ProjectorSetup setup_projector(const Projector& projector);

struct SampleSetup {
  int kind = SAMPLER_TABLE;
  std::uint32_t n = 0;  ///< iterations of the sample loop
  Factors factors{1, 1};
  std::vector<gpu::vec4> table;
  std::vector<gpu::uvec4> sobol;
};
SampleSetup setup_samples(const Twin& twin, const Camera& camera, const PackedScene& scene,
                          const Sampling& sampling);

/// Per-pixel limits of the adaptive kernels.
struct AdaptiveTargets {
  double phase_rad = 0.0;
  double irradiance = 0.0;   ///< for a pattern of full modulation
  int gauss_order = 0;       ///< of the rule that stands in for the closed form, 0: the closed form is used
  std::uint32_t panels = 1;  ///< of LINES_PER_PANEL scan lines each, per mixed pixel
  std::uint32_t stretches = 1;  ///< of a scan line, each with an invocation of its own
};
void set_adaptive(const Twin& twin, const Camera& camera, const AdaptiveTargets& targets, ParamsBlock* block);

ParamsBlock make_params(const Twin& twin, const Camera& camera, const PackedScene& scene,
                        const LensTable& lens, const ProjectorSetup& projector, const SampleSetup& samples,
                        const PassPlan& pass, std::uint64_t seed);

SpecConstants make_constants(const Twin& twin, const Camera& camera, const PackedScene& scene,
                             const LensTable& lens, const ProjectorSetup& projector,
                             const SampleSetup& samples, const PassPlan& pass, int links);

/// Blocks of pixels that may see an object, as x | y << 16.
std::vector<std::uint32_t> active_blocks(const Camera& camera, const PackedScene& scene,
                                         const LensTable& lens);

}  // namespace fringetwin::render
