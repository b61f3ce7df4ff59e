// SPDX-License-Identifier: Apache-2.0
#include "cosim/compare_captures.hpp"

#include <utility>

#include "cosim/brightness.hpp"
#include "cosim/doubt_description.hpp"
#include "cosim/load.hpp"
#include "cosim/notes.hpp"
#include "cosim/other_noise.hpp"
#include "cosim/shape/measured_shapes.hpp"
#include "measure/measurement.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cosim {
namespace {

Captures load_listed(Run& run, const std::filesystem::path& dir) {
  Captures captures = load_captures(run.twin, dir);
  run.capture_files.insert(run.capture_files.end(), captures.files.begin(), captures.files.end());
  return captures;
}

/// Returns the irradiance (EXR) of the simulated set or of the one beside its PNGs; empty where there is
/// none.
std::vector<CameraImages> load_irradiance(Run& run, const std::filesystem::path& dir) {
  if (run.simulated.images.empty()) return {};
  if (run.simulated.images.front().radiance) return run.simulated.images;
  const std::filesystem::path beside = dir / "radiance";
  return std::filesystem::exists(beside / "capture.toml") ? load_listed(run, beside).cameras
                                                          : std::vector<CameraImages>();
}

}  // namespace

Run measure_both(const CompareRequest& request) {
  Run run;
  run.timer.start("load");
  run.twin = load_for_run(request.twin);
  run.options.use_steps = left_over_steps(run.twin);
  Captures real = load_listed(run, request.real), simulated = load_listed(run, request.simulated);
  run.real.images = std::move(real.cameras);
  run.real_seed = real.rendered_seed;
  run.simulated.images = std::move(simulated.cameras);
  run.simulated.irradiance = load_irradiance(run, request.simulated);
  if (has_measured_shape(run.twin)) {
    run.timer.start("build_object");
    run.options.note = measured_shape_note(run.twin, run.options.use_steps);
    run.options.shape_noise = build_compared_shapes(run.twin, run.real.images, run.options.use_steps);
  }
  run.timer.start("measure");
  run.simulated.measurement = measure::measure(run.twin, run.simulated.images, run.options.use_steps);
  run.real.measurement = measure::measure(run.twin, run.real.images, run.options.use_steps);
  if (!run.simulated.irradiance.empty()) {
    run.noise_free = measure::noise_free_points(run.twin, run.simulated.irradiance,
                                                *run.simulated.measurement, run.options.use_steps);
    for (compare::Side* side : {&run.simulated, &run.real})
      measure::state_method_bias(run.twin, run.noise_free, *side->measurement);
  } else if (run.twin.measure.correct_pixel_area)
    run.real.measurement->warnings.emplace_back(
        "[measure] correct_pixel_area has no effect: the simulated side has no images without noise (render "
        "--radiance writes them)");
  run.timer.stop();
  add_to_warnings(run, doubts_about_real_side(run));
  add_brightness_warnings(run);
  add_first_warning(run, same_noise_warning(run.twin, run.real_seed, simulated.rendered_seed));
  return run;
}

}  // namespace fringetwin::cosim
