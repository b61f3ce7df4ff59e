// SPDX-License-Identifier: Apache-2.0
// cosim: render, measure both, compare, report.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/results.hpp"
#include "compare/causes/refine.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "render/sensor/sensor.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/measured_steps.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {

namespace {

struct CosimCommand {
  std::string twin;
  std::string out;
  std::vector<std::string> refine;
  std::string steps;  ///< "even" | "odd"; empty = all that may be compared
  RenderFlags flags;
};

/// Both sides of a run that share a twin.
struct Run {
  const CosimCommand& command;
  Twin twin;
  compare::CompareOptions options;
  compare::Side real, simulated;
  std::string device;
  std::string refined_toml;
  StageTimer timer;

  void measure_side(compare::Side& side, const std::string& name) {
    timer.start("measure_" + name);
    side.measurement = measure::measure(twin, side.images, options.use_steps);
    timer.stop();
    for (const auto& [stage, seconds] : side.measurement->timing_s)
      timer.seconds[stage + "_" + name] = seconds;
  }
  /// Factors per pixel where they were refined; the sensor then sees the images anew.
  void texture() {
    if (options.refinement->texture.empty()) return;
    std::vector<int> images;
    const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
    for (std::size_t k = 0; k < patterns.size(); ++k)
      if (!patterns[k].is_gray() && !patterns[k].is_image()) images.push_back(static_cast<int>(k));
    compare::apply_texture(*options.refinement, real.images, images, simulated.irradiance);
    for (std::size_t c = 0; c < twin.cameras.size(); ++c)
      for (std::size_t k = 0; k < patterns.size(); ++k)
        simulated.images[c].images[k] =
            render::expose(simulated.irradiance[c].images[k], twin.cameras[c].sensor, command.flags.seed,
                           static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(k));
  }
  void render_and_measure(render::Renderer& renderer) {
    timer.start("render");
    Simulated rendered = simulate(twin, command.flags, renderer);
    timer.stop();
    simulated.images = std::move(rendered.captures);
    simulated.irradiance = std::move(rendered.irradiance);
    options.rendered = std::move(rendered.notes);
    device = rendered.device;
    if (options.refinement) texture();
    measure_side(simulated, "simulated");
    if (!real.images.empty()) measure_side(real, "real");
  }
};

/// Every second phase step, of those that may be compared.
std::vector<int> steps_of(const Twin& twin, const std::string& which, const std::vector<int>& allowed) {
  std::vector<int> steps;
  for (int n = which == "odd" ? 1 : 0; n < twin.fringes.steps; n += 2)
    if (allowed.empty() || std::find(allowed.begin(), allowed.end(), n) != allowed.end()) steps.push_back(n);
  if (steps.size() < 3)
    throw UserError(ExitCode::usage, "--steps " + which,
                    fmt::format("leaves {} phase steps to compare, and a phase needs 3", steps.size()),
                    allowed.empty() ? "compare all of them"
                                    : "a measured object is built from the others: give it steps = \"all\"");
  return steps;
}

void refine_twin(Run& run, render::Renderer& renderer) {
  if (run.command.refine.empty()) return;
  run.timer.start("refine");
  compare::CompareOptions options = run.options;
  options.use_steps = left_over_steps(run.twin);  // --steps chooses what is compared, not what is known
  compare::Refined refined = compare::refine(run.twin, run.real, run.simulated, options, run.command.refine);
  run.timer.stop();
  run.refined_toml = compare::refined_toml(refined.report, run.twin, refined.twin);
  run.twin = std::move(refined.twin);
  run.options.refinement = std::move(refined.report);
  run.render_and_measure(renderer);
}

int run_cosim(const CosimCommand& o, const Invocation& invocation) {
  if (o.flags.device == "list") return print_devices();
  if (o.twin.empty() || o.out.empty())
    throw UserError(ExitCode::usage, "cosim", "a twin and --out are needed",
                    "fringetwin cosim TWIN.toml --out DIR");
  check_out_folder(o.out);
  Run run{o, {}, {}, {}, {}, {}, {}, {}};
  run.timer.start("load");
  run.twin = load_for_run(o.twin);
  check_renderable(run.twin);
  if (run.twin.calibration_uncertainty) compare::read_calibration_covariance(run.twin);  // before the work
  run.options.use_steps = left_over_steps(run.twin);
  if (!o.steps.empty()) run.options.use_steps = steps_of(run.twin, o.steps, run.options.use_steps);
  std::vector<std::filesystem::path> real_files;
  if (run.twin.real.captures) {
    run.real.images = load_captures(run.twin, *run.twin.real.captures);
    real_files = capture_files(run.twin, *run.twin.real.captures);
  } else if (!o.refine.empty()) {
    throw UserError(ExitCode::usage, o.twin, "--refine needs real images, but [real] names no captures",
                    "add [real] captures = \"FOLDER\"");
  }
  run.options.note = published_results_note(run.twin);
  if (has_measured_shape(run.twin)) {
    if (!run.twin.real.captures)
      throw UserError(ExitCode::usage, o.twin,
                      "an object has shape = \"measured\" but [real] names no captures",
                      "add [real] captures = \"FOLDER\"");
    run.timer.start("build_object");
    const Twin as_written = run.twin;
    build_measured_shapes(run.twin, run.real.images);
    run.options.note = measured_shape_note(as_written, run.options.use_steps);
  }
  compare::check_refine(run.twin, o.refine);
  if (needs_white_black(run.twin.fringes) &&
      std::find(o.refine.begin(), o.refine.end(), "texture") != o.refine.end())
    throw UserError(ExitCode::usage, "--refine texture",
                    "white and black reference images have no factors of their own",
                    "use threshold = \"mean\" or \"inverse\"");

  render::Renderer renderer(o.flags.device);
  run.options.renderer = &renderer;
  run.options.seed = o.flags.seed;
  run.options.render = run.twin.render;
  apply_flags(o.flags, *run.options.render);
  run.render_and_measure(renderer);
  refine_twin(run, renderer);
  say(fmt::format("simulated measurement of {} images: render {:.2f} s + measure {:.2f} s on {}",
                  run.simulated.images.size() * run.simulated.images.front().images.size(),
                  run.timer.seconds["render"], run.timer.seconds["measure_simulated"], run.device));

  run.timer.start("write");
  Simulated for_disk{std::move(run.simulated.images), std::move(run.simulated.irradiance),
                     run.options.rendered, run.device};
  begin_output(o.out, {"result.json", "refined.toml", "report.html"});
  write_simulated(std::filesystem::path(o.out) / "simulated", for_disk, o.flags.radiance, o.flags.seed,
                  run.twin);
  run.simulated.images = std::move(for_disk.captures);
  run.simulated.irradiance = std::move(for_disk.irradiance);
  if (run.options.refinement)
    write_text_file(std::filesystem::path(o.out) / "refined.toml", run.refined_toml);
  run.timer.stop();

  auto provenance = make_provenance(invocation, run.twin, real_files, run.device, o.flags.seed);
  provenance.rendered = run.options.rendered;
  return finish_comparison(o.out, run.twin, run.real, run.simulated, run.options, provenance, run.timer);
}

}  // namespace

void add_cosim(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<CosimCommand>();
  CLI::App* sub = app.add_subcommand("cosim", "The main job: render, measure both, compare, report");
  sub->add_option("twin", options->twin, "The twin.toml");
  sub->add_option("--out", options->out,
                  "Folder for result.json, report.html, maps and the simulated capture set");
  sub->add_option("--refine", options->refine,
                  "Fit these to the real images first: " + compare::refine_names() +
                      ", or a parameter by its name (projector.k1)")
      ->delimiter(',');
  sub->add_option("--steps", options->steps, "Compare every second phase step only")
      ->check(CLI::IsMember({"even", "odd"}));
  add_render_flags(*sub, options->flags);
  sub->add_flag("--radiance", options->flags.radiance, "Also write float32 EXR images (E before the sensor)");
  sub->callback([options, &invocation] {
    invocation.run = [options, &invocation] { return run_cosim(*options, invocation); };
  });
}

}  // namespace fringetwin::cli
