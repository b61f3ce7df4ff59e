// SPDX-License-Identifier: Apache-2.0
// measure: one capture set -> phase, points, fits.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/extra_file_flags.hpp"
#include "cli/option_groups.hpp"
#include "cli/tell/json_output.hpp"
#include "cli/tell/tell_comparison.hpp"
#include "cli/twin_argument.hpp"
#include "compare/result/result_json.hpp"
#include "cosim/load.hpp"
#include "cosim/measure_captures.hpp"
#include "cosim/summary.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

struct MeasureCommand {
  std::string twin;
  std::string captures;
  std::string out;
  cosim::ExtraFiles extra;
  bool method_bias = false, json = false;
};

int run_measure(const MeasureCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  StageTimer timer;
  timer.start("load");
  const Twin twin = cosim::load_for_run(o.twin);
  cosim::measuring_renders(twin, o.method_bias);  // may be refused, before the images are read
  const cosim::Captures captures = cosim::load_captures(twin, o.captures);
  const measure::Measurement measurement =
      cosim::measure_captures(twin, captures.cameras, o.method_bias, timer);
  cosim::write_measured(o.out, twin, measurement, captures.files, {invocation.argv, version_string()}, timer,
                        o.extra);

  for (const auto& warning : measurement.warnings) warn(warning);
  std::vector<compare::LightRow> light;
  compare::add_light_rows(measurement, "", light);
  for (const std::string& line : cosim::light_lines(light)) say(line);
  for (const auto& camera : measurement.cameras)
    for (const auto& direction : camera.directions)
      say(fmt::format("{} {}: {} pixels checked for fringe order, {} moved by a period, {} jumps left",
                      camera.camera, axis_name(direction.axis), direction.repair.n_checked,
                      direction.repair.n_changed, direction.repair.n_left));
  say(fmt::format("{} points of {} candidates", measurement.cloud.size(),
                  measurement.triangulation.n_candidates));
  for (const auto& fit : measurement.fits) {
    if (!fit.usable) {
      warn(fmt::format("fit of \"{}\": {} (n = {})", fit.object, fit.warning, fit.n));
      continue;
    }
    say(fmt::format("{} ({}): rms {:.6f} mm on {} points, {:.6f} mm on all {:.0f} within the gate",
                    fit.object, fit.kind, fit.numbers.at("rms_mm"), fit.n, fit.numbers.at("rms_all_mm"),
                    fit.numbers.at("n_gated")));
  }
  say(fmt::format("measured in {:.2f} s; written to {}", timer.seconds["measure"], o.out));
  print_json_if(o.json, std::filesystem::path(o.out) / "result.json");
  return code_with_figures(o.extra.figures, o.out, convergence_exit_code(measurement, 0));
}

}  // namespace

void add_measure(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<MeasureCommand>();
  CLI::App* sub =
      app.add_subcommand("measure", "Capture set -> phase, points, fits (real and simulated alike)");
  add_twin_argument(*sub, options->twin, "The twin.toml")->required();
  begin_group(*sub, kInput);
  sub->add_option("--captures", options->captures, "Folder with a capture.toml")
      ->type_name("DIR")
      ->required();
  begin_group(*sub, kOutput);
  sub->add_option("--out", options->out,
                  "Folder for report.html, points.ply, phase_<camera>.exr, result.json")
      ->type_name("DIR")
      ->required();
  add_npz_flag(*sub, options->extra);
  add_figures_flag(*sub, options->extra);
  add_json_flag(*sub, options->json, "result.json");
  begin_group(*sub, "Uncertainty");
  sub->add_flag("--method-bias", options->method_bias,
                "Render the twin once and state what the method itself adds to each fit");
  run_when_chosen(*sub, invocation, options, run_measure);
}

}  // namespace fringetwin::cli
