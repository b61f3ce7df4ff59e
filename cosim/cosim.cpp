// SPDX-License-Identifier: Apache-2.0
#include "cosim/cosim.hpp"

#include <algorithm>
#include <utility>

#include "compare/comparison.hpp"
#include "compare/refine/apply_texture.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "compare/refine/refine.hpp"
#include "compare/refine/refine_guard.hpp"
#include "compare/refine/refined_budget.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "cosim/brightness.hpp"
#include "cosim/compared_steps.hpp"
#include "cosim/doubt_description.hpp"
#include "cosim/hold_out.hpp"
#include "cosim/load.hpp"
#include "cosim/notes.hpp"
#include "cosim/other_noise.hpp"
#include "cosim/refined_into_twin.hpp"
#include "cosim/shape/measured_shapes.hpp"
#include "measure/measurement.hpp"
#include "render/sensor/sensor.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cosim {
namespace {

void check_refine(const Twin& twin, const std::vector<std::string>& asked) {
  compare::check_refine(twin, asked);
  for (const char* own : {"texture", "offset"})
    if (needs_white_black(twin.fringes) && std::ranges::find(asked, own) != asked.end())
      throw UserError(ExitCode::usage, std::string("--refine ") + own,
                      "white and black reference images have no factors of their own",
                      "use threshold = \"mean\" or \"inverse\"");
}

/// Loads everything that is read and checks everything that can be checked before a device is opened.
Run load_run(const CosimRequest& request) {
  Run run;
  run.timer.start("load");
  run.twin = load_for_run(request.twin, request.settings);
  check_renderable(run.twin);
  if (!request.into.empty()) check_refined_into_twin(run.twin, request.refine, request.into);
  if (run.twin.calibration_uncertainty)  // may be refused, before the work
    run.options.calibration = std::make_shared<const compare::CalibrationCovariance>(
        compare::read_calibration_covariance(run.twin));
  run.options.use_steps = left_over_steps(run.twin);
  if (!request.steps.empty())
    run.options.use_steps = compared_steps(run.twin, request.steps, run.options.use_steps);
  if (run.twin.real.captures) {
    Captures captures = load_captures(run.twin, *run.twin.real.captures);
    run.real.images = std::move(captures.cameras);
    run.capture_files = std::move(captures.files);
    run.real_seed = captures.rendered_seed;
  } else if (!request.refine.empty()) {
    throw UserError(ExitCode::usage, request.twin.string(),
                    "--refine needs real images, but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
  }
  if (request.hold_out > 0) run.twin.compare.hold_out = request.hold_out;
  if (!request.hold_out_by.empty()) run.twin.compare.hold_out_by = held_out_by(request.hold_out_by);
  check_hold_out(run, request.refine);
  run.options.note = published_results_note(run.twin);
  check_measured_shapes(run.twin);
  if (run.twin.compare.hold_out > 0) run.as_written = run.twin;
  if (has_measured_shape(run.twin)) {
    run.timer.start("build_object");
    run.options.note = measured_shape_note(run.twin, run.options.use_steps);
    run.options.shape_noise = build_compared_shapes(run.twin, run.real.images, run.options.use_steps);
  }
  check_refine(run.twin, request.refine);
  return run;
}

void keep_times(Run& run, const measure::Measurement& measurement, const std::string& side) {
  for (const auto& [stage, seconds] : measurement.timing_s) run.timer.seconds[stage + "_" + side] = seconds;
}

/// Drops what no comparison asks of the simulated side.
void drop_coarse_amplitudes(measure::Measurement& measurement) {
  for (measure::CameraDecode& camera : measurement.cameras)
    for (measure::DirectionDecode& d : camera.directions)
      for (std::size_t p = 0; p < d.amplitude_dn.size(); ++p)
        if (static_cast<int>(p) != d.finest && !d.wrapped_rad.empty()) d.amplitude_dn[p] = {};
}

void measure_simulated(Run& run) {
  run.timer.start("measure_simulated");
  run.simulated.measurement = measure::measure(run.twin, run.simulated.images, run.options.use_steps);
  run.noise_free = measure::noise_free_points(run.twin, run.simulated.irradiance, *run.simulated.measurement,
                                              run.options.use_steps);
  measure::state_method_bias(run.twin, run.noise_free, *run.simulated.measurement);
  drop_coarse_amplitudes(*run.simulated.measurement);
  run.timer.stop();
  keep_times(run, *run.simulated.measurement, "simulated");
}

/// Measures the real images. What was decoded with the twin as it was `before` serves again where that twin
/// decodes alike: a pose, for one, changes points and fits only.
void measure_real(Run& run, const Twin* before = nullptr) {
  if (run.real.images.empty()) return;
  run.timer.start("measure_real");
  std::optional<measure::Measurement>& real = run.real.measurement;
  if (real && before && measure::decodes_alike(*before, run.twin, run.real.images)) {
    const double decode_s = real->timing_s["decode"];
    real = measure::measure_decoded(run.twin, std::move(real->cameras));
    real->timing_s["decode"] = decode_s;
  } else {
    real = measure::measure(run.twin, run.real.images, run.options.use_steps);
  }
  measure::state_method_bias(run.twin, run.noise_free, *real);
  run.timer.stop();
  keep_times(run, *real, "real");
}

/// Gives every pixel the factor and the offset that were refined; the sensor then sees the images anew. Phase
/// steps tell them, of a code alone its bits.
void apply_texture(Run& run) {
  std::vector<int> images;
  const std::vector<PatternSpec> patterns = expand_sequence(run.twin.fringes);
  const bool code_alone = run.twin.fringes.steps == 0;
  for (std::size_t k = 0; k < patterns.size(); ++k)
    if (!patterns[k].is_image() && patterns[k].is_gray() == code_alone) images.push_back(static_cast<int>(k));
  compare::apply_texture(*run.options.refinement, run.real.images, images, run.twin,
                         run.simulated.irradiance);
  for (std::size_t c = 0; c < run.twin.cameras.size(); ++c)
    for (std::size_t k = 0; k < patterns.size(); ++k)
      run.simulated.images[c].images[k] = GrayImage::packed(
          render::expose(run.simulated.irradiance[c].images[k], run.twin.cameras[c].sensor,
                         run.rendering.seed, static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(k)));
}

void simulate_side(Run& run, const RenderRequest& request) {
  run.timer.start("render");
  Simulated simulated = simulate(run.twin, request, *run.renderer);
  run.timer.stop();
  run.simulated.images = std::move(simulated.captures);
  run.simulated.irradiance = std::move(simulated.irradiance);
  run.rendering = std::move(simulated.rendering);
  run.options.rendered = run.rendering.notes;
  if (run.options.textured()) apply_texture(run);
  measure_simulated(run);
}

/// Returns the rows of the verdict that a refinement must not make worse.
std::vector<compare::ExplainedRow> guarded_rows(const Run& run) {
  std::vector<compare::ExplainedRow> rows =
      compare::measured_rows(run.twin, run.real, run.simulated, run.options.refined_budget.get());
  for (compare::ExplainedRow& row : compare::explain_phases(run.twin, run.real, run.simulated, run.options))
    rows.push_back(std::move(row));
  return rows;
}

/// Fits the twin to the real images, then renders and measures with the twin as fitted. Takes it back where
/// coverage, phase or the objects' fits got worse by it.
void refine(Run& run, const CosimRequest& request) {
  run.timer.start("refine");
  compare::CompareOptions options = run.options;
  options.use_steps = left_over_steps(run.twin);  // --steps chooses what is compared, not what is known
  compare::Refined refined = compare::refine(run.twin, run.real, run.simulated, options, request.refine);
  run.timer.stop();
  const auto keep_changes = [&run](const Twin& before, const Twin& after) {
    run.refined_toml = compare::refined_toml(*run.options.refinement, before, after);
    run.refined_blocks = compare::refined_blocks(before, after);
  };
  run.options.refinement = std::move(refined.report);
  if (run.options.refinement->taken_back) return keep_changes(run.twin, refined.twin);
  run.options.one_error_away = std::move(refined.one_error_away);
  const std::vector<compare::ExplainedRow> before_rows = guarded_rows(run);
  const Twin before = std::exchange(run.twin, std::move(refined.twin));
  const compare::Side simulated = std::exchange(run.simulated, {});
  const measure::PointCloud noise_free = run.noise_free;
  const Rendering rendering = run.rendering;
  compare::drop_texture_told_anew(*run.options.refinement, run.twin);
  simulate_side(run, request.render);  // tells what each pixel has of its own, too
  keep_changes(before, run.twin);
  measure_real(run, &before);
  run.timer.start("refined_errors");
  std::vector<compare::ExplainedRow> after_rows = guarded_rows(run);
  if (auto budget = compare::refined_budget(run.twin, run.simulated, run.options, after_rows)) {
    run.options.refined_budget = std::make_shared<const compare::RigBudget>(std::move(*budget));
    compare::excuse(after_rows, guarded_rows(run));
  }
  run.timer.stop();
  const std::string worse = compare::what_got_worse({.rows = before_rows}, {.rows = after_rows});
  if (worse.empty()) {
    compare::Refinement& report = *run.options.refinement;
    if (std::string left = compare::warning_of_what_is_left(report, after_rows); !left.empty())
      report.warnings.push_back(std::move(left));
    return;
  }
  const Twin after = run.twin;
  compare::Refined back{after, *run.options.refinement};
  compare::take_back(back, before, worse);
  run.twin = before;
  run.options.refinement = std::move(back.report);
  run.options.one_error_away.clear();
  run.options.refined_budget.reset();
  keep_changes(before, before);
  run.simulated = simulated;
  run.noise_free = noise_free;
  run.rendering = rendering;
  run.options.rendered = rendering.notes;
  measure_real(run, &after);
}

}  // namespace

Run run_cosim(const CosimRequest& asked) {
  CosimRequest request = asked;
  Run run = load_run(request);
  const ChosenSeed chosen = choose_seed(run.twin, asked.render.seed, run.real_seed);
  request.render.seed = chosen.seed;  // every rendering of the run takes this one
  if (!chosen.note.empty()) {
    say(chosen.note);
    if (!run.options.note.empty()) run.options.note += ' ';
    run.options.note += chosen.note;
  }
  run.renderer = std::make_unique<render::Renderer>(request.render.device);
  run.options.renderer = run.renderer.get();
  run.options.seed = chosen.seed;
  run.options.render = render_options(run.twin, request.render);
  simulate_side(run, request.render);
  measure_real(run);
  // before refining: a twin that was bent to fit a wrong description contradicts nothing any more
  const std::vector<measure::Doubt> doubts = doubts_about_real_side(run);
  run.options.shows_other_fringes = std::ranges::any_of(doubts, &measure::Doubt::shows_other_fringes);
  try {
    hold_out(run, request.render, request.refine);
    if (!request.refine.empty()) refine(run, request);
  } catch (const UserError&) {
    for (const measure::Doubt& doubt : doubts) warn(doubt.sentence);
    throw;
  }
  run.noise_free = {};  // no measurement follows
  add_to_warnings(run, doubts);
  add_brightness_warnings(run);
  add_first_warning(run, chosen.warning);
  return run;
}

}  // namespace fringetwin::cosim
