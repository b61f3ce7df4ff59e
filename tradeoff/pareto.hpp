// SPDX-License-Identifier: Apache-2.0
// Measures (`fringetwin pareto`) every scheme x sample count x precision on the user's own scene: error
// against the double-precision reference, and time.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/result/provenance.hpp"
#include "render/renderer.hpp"
#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"
#include "tradeoff/reference_values.hpp"
#include "tradeoff/schemes.hpp"
#include "twin/base/constants.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

struct ParetoOptions {
  bool quick = false;
  SubsetOptions subset;
  ReferenceOptions reference;
  int rounds = 3;               ///< timed renders, all schemes in turns; the smallest counts
  double retime_below_s = 3.0;  ///< slower points are timed once
  /// A point predicted to take longer (all cameras) is rendered in the subset's windows only: its error is
  /// measured, its time extrapolated, its fit unknown.
  double longest_point_s = 120.0;
  std::uint64_t seed = 0;
};

struct ParetoPoint {
  Scheme scheme;
  ImageChange error;
  /// One camera's whole frame with all its images: wall and CPU time, mean over the cameras.
  double frame_ms = kNaN;
  double frame_cpu_ms = kNaN;
  int extrapolated_from = 0;  ///< samples of the measured member of the family; 0 = measured
  std::uint64_t rays = 0;     ///< all cameras; 0 where extrapolated
  // The whole chain; NaN where it has no fit or was not run:
  double fit_error_mm = kNaN;  ///< against what was put in
  double fit_rms_mm = kNaN;
  /// Against the fit of the most exact rendering of this run (smallest gray error of all pixels): the share
  /// of the scheme in the fit. What was put in differs also by what the method itself does to it.
  double fit_shift_mm = kNaN;
  bool is_fit_reference = false;
  double measure_s = kNaN;
  double chain_s = kNaN;  ///< render + sensor + measure, all cameras
  bool on_phase_front = false, on_gray_front = false, on_fit_front = false;
  bool is_precise() const { return scheme.sampling.precise; }
  std::string precision() const { return is_precise() ? "fp64" : "fp32"; }
  std::string name() const;  ///< "gauss 4, fp32"
};

struct ParetoResult {
  std::vector<ParetoPoint> points;
  PixelSubset subset;
  render::DeviceInfo device;
  bool has_fits = false;
  double reference_uncertainty_dn = 0.0;
  std::vector<std::string> warnings;
  std::map<std::string, double> timing_s;
};

/// One camera's whole frame with all its images, as predicted from a measured point.
struct PredictedTime {
  double frame_ms = kNaN, frame_cpu_ms = kNaN;
  int from_samples = 0;  ///< of that point
};
/// Returns the time of the largest measured member of the point's family, in proportion to the samples; of
/// adaptive sampling, whose samples nobody knows before, that time itself. Nothing where none was measured.
std::optional<PredictedTime> predict_time(const std::vector<ParetoPoint>& points, const ParetoPoint& point);
/// Gives every point without a time the predicted one, if there is one.
void extrapolate_times(std::vector<ParetoPoint>& points);

/// Marks the points no other beats: time against interior phase error, against gray error of all pixels,
/// and chain time against fit shift (the reference of the shifts takes no part).
void mark_fronts(std::vector<ParetoPoint>& points);

/// Renders the scene by every scheme, and measures error and time. Meshes must be loaded and measured shapes
/// built. Throws UserError(usage), Cancelled.
ParetoResult run_pareto(const Twin& twin, render::Renderer& renderer, const ParetoOptions& options);

/// Returns the table as text, for stdout; the whole as JSON; the page.
std::string pareto_table(const ParetoResult& result);
std::string pareto_json(const Twin& twin, const ParetoResult& result, const ParetoOptions& options,
                        const compare::Provenance& provenance);
std::string pareto_html(const Twin& twin, const ParetoResult& result, const ParetoOptions& options,
                        const compare::Provenance& provenance);

}  // namespace fringetwin::tradeoff
