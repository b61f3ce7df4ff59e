// SPDX-License-Identifier: Apache-2.0
// cosim: render, measure both, compare, report.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/out_folder.hpp"
#include "cli/results.hpp"
#include "twin/errors.hpp"
#include "twin/measured_steps.hpp"
#include "twin/progress.hpp"

namespace fringetwin::cli {

namespace {

struct CosimCommand {
  std::string twin;
  std::string out;
  RenderFlags flags;
};

void add_times(StageTimer& timer, const std::string& side, const measure::Measurement& measurement) {
  for (const auto& [stage, seconds] : measurement.timing_s) timer.seconds[stage + "_" + side] = seconds;
}

int run_cosim(const CosimCommand& o, const Invocation& invocation) {
  if (o.flags.device == "list") return print_devices();
  if (o.twin.empty() || o.out.empty())
    throw UserError(ExitCode::usage, "cosim", "a twin and --out are needed",
                    "fringetwin cosim TWIN.toml --out DIR");
  check_out_folder(o.out);
  StageTimer timer;
  timer.start("load");
  Twin twin = load_for_run(o.twin);
  compare::CompareOptions options;
  options.use_steps = left_over_steps(twin);
  compare::Side real, simulated;
  std::vector<std::filesystem::path> real_files;
  if (twin.real.captures) {
    real.images = load_captures(twin, *twin.real.captures);
    real_files = capture_files(twin, *twin.real.captures);
  }
  options.note = published_results_note(twin);
  if (has_measured_shape(twin)) {
    if (!twin.real.captures)
      throw UserError(ExitCode::usage, o.twin,
                      "an object has shape = \"measured\" but [real] names no captures",
                      "add [real] captures = \"FOLDER\"");
    timer.start("build_object");
    const Twin as_written = twin;
    build_measured_shapes(twin, real.images);
    options.note = measured_shape_note(as_written, options.use_steps);
  }

  timer.start("render");
  Simulated rendered = simulate(twin, o.flags);
  simulated.images = std::move(rendered.captures);
  simulated.irradiance = std::move(rendered.irradiance);
  timer.start("measure_simulated");
  simulated.measurement = measure::measure(twin, simulated.images, options.use_steps);
  timer.stop();
  add_times(timer, "simulated", *simulated.measurement);
  if (twin.real.captures) {
    timer.start("measure_real");
    real.measurement = measure::measure(twin, real.images, options.use_steps);
    timer.stop();
    add_times(timer, "real", *real.measurement);
  }
  say(fmt::format("simulated measurement of {} images: render {:.2f} s + measure {:.2f} s on {}",
                  simulated.images.size() * simulated.images.front().images.size(), timer.seconds["render"],
                  timer.seconds["measure_simulated"], rendered.device));

  timer.start("write");
  Simulated for_disk{std::move(simulated.images), std::move(simulated.irradiance), rendered.notes,
                     rendered.device};
  begin_output(o.out, {"result.json"});
  write_simulated(std::filesystem::path(o.out) / "simulated", for_disk, o.flags.radiance, o.flags.seed, twin);
  simulated.images = std::move(for_disk.captures);
  simulated.irradiance = std::move(for_disk.irradiance);
  timer.stop();

  auto provenance = make_provenance(invocation, twin, real_files, rendered.device, o.flags.seed);
  provenance.rendered = rendered.notes;
  return finish_comparison(o.out, twin, real, simulated, options, provenance, timer);
}

}  // namespace

void add_cosim(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<CosimCommand>();
  CLI::App* sub = app.add_subcommand("cosim", "The main job: render, measure both, compare, report");
  sub->add_option("twin", options->twin, "The twin.toml");
  sub->add_option("--out", options->out,
                  "Folder for result.json, report.html, maps and the simulated capture set");
  add_render_flags(*sub, options->flags);
  sub->add_flag("--radiance", options->flags.radiance, "Also write float32 EXR images (E before the sensor)");
  sub->callback([options, &invocation] {
    invocation.run = [options, &invocation] { return run_cosim(*options, invocation); };
  });
}

}  // namespace fringetwin::cli
