// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <filesystem>

#include "cli/commands.hpp"
#include "cli/results.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/captures/measured_steps.hpp"

namespace fringetwin::cli {

namespace {

struct CompareCommand {
  std::string twin;
  std::string real;
  std::string sim;
  std::string out;
};

bool has_irradiance_beside(const std::filesystem::path& sim_dir, const std::vector<CameraImages>& simulated) {
  return !simulated.empty() && !simulated.front().radiance &&
         std::filesystem::exists(sim_dir / "radiance" / "capture.toml");
}

/// The irradiance (EXR) beside the simulated PNGs, where `render --radiance` wrote it; else empty.
std::vector<CameraImages> load_irradiance(const Twin& twin, const std::filesystem::path& sim_dir,
                                          const std::vector<CameraImages>& simulated) {
  if (!simulated.empty() && simulated.front().radiance) return simulated;
  if (has_irradiance_beside(sim_dir, simulated)) return load_captures(twin, sim_dir / "radiance");
  return {};
}

int run_compare(const CompareCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  StageTimer timer;
  timer.start("load");
  Twin twin = load_for_run(o.twin);
  compare::CompareOptions options;
  options.use_steps = left_over_steps(twin);
  compare::Side real, simulated;
  real.images = load_captures(twin, o.real);
  simulated.images = load_captures(twin, o.sim);
  simulated.irradiance = load_irradiance(twin, o.sim, simulated.images);
  if (has_measured_shape(twin)) {
    timer.start("build_object");
    const Twin as_written = twin;
    build_measured_shapes(twin, real.images);
    options.note = measured_shape_note(as_written, options.use_steps);
  }
  timer.start("measure");
  simulated.measurement = measure::measure(twin, simulated.images, options.use_steps);
  real.measurement = measure::measure(twin, real.images, options.use_steps);
  timer.stop();
  std::vector<std::filesystem::path> files = capture_files(twin, o.real);
  for (const auto& file : capture_files(twin, o.sim)) files.push_back(file);
  if (has_irradiance_beside(o.sim, simulated.images))
    for (const auto& file : capture_files(twin, std::filesystem::path(o.sim) / "radiance"))
      files.push_back(file);
  return finish_comparison(o.out, twin, real, simulated, options,
                           make_provenance(invocation, twin, files, "", 0), timer);
}

}  // namespace

void add_compare(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<CompareCommand>();
  CLI::App* sub = app.add_subcommand("compare", "Measure two capture sets and compare them");
  sub->add_option("twin", options->twin, "The twin.toml")->required();
  sub->add_option("--real", options->real, "Capture set of the rig")->required();
  sub->add_option("--sim", options->sim, "Capture set of the twin")->required();
  sub->add_option("--out", options->out, "Folder for result.json, report.html and the maps")->required();
  sub->callback([options, &invocation] {
    invocation.run = [options, &invocation] { return run_compare(*options, invocation); };
  });
}

}  // namespace fringetwin::cli
