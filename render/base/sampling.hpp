// SPDX-License-Identifier: Apache-2.0
// Chooses how a pixel is sampled: from a twin's render options come the rule and the number of samples that
// meet the targets of phase and gray error at the least cost.
#pragma once
#include "twin/twin.hpp"

namespace fringetwin::render {

/// How the pixels are sampled, after the defaults.
///  gauss: samples = n x n Gauss-Legendre; multi_jittered, sobol: any number;
///  adaptive: one ray and a closed form where one surface fills the pixel's neighbourhood, facets clipped
///  exactly, more rays only where the estimated error is too large and along edges (docs/PHYSICS.md);
///  `samples` is then meaningless.
struct Sampling {
  Sampler sampler = Sampler::gauss;
  int samples = 4;
  bool precise = false;           ///< rays and phases in double precision, where the device can
  double phase_error_rad = 1e-4;  ///< adaptive: target at the finest pitch
  double gray_error = 1e-4;       ///< adaptive: target, fraction of the sensor's full scale
};

/// Returns the total phase error (rms, rad) of the single-precision kernels on the worst scene, a tilted
/// plane over the whole frame; for targets below it double precision is used. Rounding shifts the projector
/// coordinate by some 6e-8 of the projector's focal length: 3.5e-5 rad measured at 1700 px and a pitch of
/// 13 px, stated as 5e-5, in proportion to focal length over pitch elsewhere.
double single_precision_error_rad(const Twin& twin);

/// Returns what the user fixed in `options`, or else what meets their targets at the least cost.
/// Throws UserError(usage) when gauss samples are no square of 1...16, or samples < 1 / > 65536.
Sampling choose_sampling(const Twin& twin, const RenderOptions& options);
/// Chooses by the twin's own options.
inline Sampling choose_sampling(const Twin& twin) { return choose_sampling(twin, twin.render); }

/// Returns the name as twin.toml spells it: "gauss", "multi-jittered" ...
const char* sampler_name(Sampler sampler);

/// Returns the fixed rule that stands in where the adaptive trace does not apply (depth of field, projector
/// optics and pixels, albedo maps); a rule that is not adaptive comes back unchanged.
Sampling without_adaptation(const Sampling& sampling);
/// Returns the same with as many points as the fringes ask for that one pixel of this camera sees: two points
/// a side leave w^4/4320 too much contrast, w the phase across the pixel.
Sampling without_adaptation(const Sampling& sampling, const Twin& twin, const Camera& camera);

/// Throws UserError(usage) for a sampling that no trace can follow, or a sampled square of more than 2 px a
/// side (`pixel_fill`).
void check_sampling(const Sampling& sampling, double pixel_fill);

}  // namespace fringetwin::render
