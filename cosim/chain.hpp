// SPDX-License-Identifier: Apache-2.0
// Render, expose, measure: the chain a study repeats, with its times.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "measure/measurement.hpp"
#include "render/renderer.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {

/// Wall time, and CPU time of all threads of this process (a software Vulkan device's included).
struct Elapsed {
  double wall_s = 0.0, cpu_s = 0.0;
};
class Stopwatch {
 public:
  Stopwatch();
  Elapsed elapsed() const;

 private:
  double wall_start_s_, cpu_start_s_;
};

struct RenderedTwin {
  std::vector<render::RenderedCamera> cameras;
  Elapsed time;
};
/// All cameras. Throws Cancelled between them.
RenderedTwin render_all(render::Renderer& renderer, const Twin& twin, const render::Sampling& sampling,
                        std::uint64_t seed);
RenderedTwin render_all(render::Renderer& renderer, const Twin& twin, std::uint64_t seed);

/// Gray values as `sensors`' cameras record them, in the DN of `units`' cameras (another bit depth of the
/// same range is scaled back), so that both can be compared and measured alike.
std::vector<CameraImages> expose_all(const std::vector<render::RenderedCamera>& rendered, const Twin& sensors,
                                     const Twin& units, std::uint64_t seed);

/// The chain can end in fits: triangulation is possible and some are asked for.
bool can_fit(const Twin& twin);

/// The fit of each [[measure.fit]], in their order.
std::vector<measure::ObjectFit> fits_in_order(const Twin& twin, const measure::Measurement& measurement);

/// How far two fits of one object are apart, mm: sphere: the larger of the distance of the centres and the
/// difference of the radii; plane: offset at the fitted point; cylinder: the larger of axis distance and
/// radius; mesh: the largest difference of the deviations' rms, mean and 95 % quantile. For the analytic
/// shapes also the difference of the residual rms. +inf when one of the two is not usable.
double fit_distance_mm(const measure::ObjectFit& a, const measure::ObjectFit& b);

/// Error of a fit against what was put in, mm: as fit_distance_mm without the residual rms; mesh: the rms
/// of the deviations from the CAD surface. NaN when the fit is not usable.
double fit_error_mm(const Twin& twin, const measure::ObjectFit& fit);

}  // namespace fringetwin::study
