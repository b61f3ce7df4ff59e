// SPDX-License-Identifier: Apache-2.0
// cosim: render, measure both, compare, report.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/render_flags.hpp"
#include "cli/tell_comparison.hpp"
#include "cli/twin_argument.hpp"
#include "compare/causes/refine.hpp"
#include "cosim/cosim.hpp"
#include "cosim/write_results.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

struct CosimCommand {
  std::string twin, out;
  cosim::CosimRequest request;
  bool radiance = false;
};

int run_cosim(CosimCommand& o, const Invocation& invocation) {
  if (o.request.render.device == "list") return print_devices();
  if (o.twin.empty() || o.out.empty())
    throw UserError(ExitCode::usage, "cosim", "a twin and --out are needed",
                    "fringetwin cosim TWIN.toml --out DIR");
  check_out_folder(o.out);
  o.request.twin = o.twin;
  cosim::Run run = cosim::run_cosim(o.request);
  say(fmt::format("simulated measurement of {} images: render {:.2f} s + measure {:.2f} s on {}",
                  run.simulated.images.size() * run.simulated.images.front().images.size(),
                  run.timer.seconds["render"], run.timer.seconds["measure_simulated"], run.rendering.device));
  cosim::write_simulated_side(o.out, run, o.radiance);
  return tell_comparison(
      o.out, run, cosim::compare_and_write(o.out, run, {invocation.argv, version_string()}), invocation.argv);
}

}  // namespace

void add_cosim(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<CosimCommand>();
  CLI::App* sub = app.add_subcommand("cosim", "The main job: render, measure both, compare, report");
  add_twin_argument(*sub, options->twin, "The twin.toml");
  sub->add_option("--out", options->out,
                  "Folder for result.json, report.html, maps and the simulated capture set")
      ->type_name("DIR");
  sub->add_option("--refine", options->request.refine,
                  "Fit these to the real images first: " + compare::refine_names() +
                      ", or a parameter by its name (projector.k1)")
      ->type_name("NAMES")
      ->delimiter(',');
  sub->add_option("--steps", options->request.steps, "Compare every second phase step only")
      ->type_name("NAME")
      ->check(CLI::IsMember({"even", "odd"}));
  sub->add_option("--hold-out", options->request.hold_out,
                  "Deal the phase steps to K folds and predict each from a fit to the others")
      ->type_name("K")
      ->check(CLI::Range(2, 64));
  add_render_flags(*sub, options->request.render);
  sub->add_flag("--radiance", options->radiance, "Also write float32 EXR images (E before the sensor)");
  run_when_chosen(*sub, invocation, options, run_cosim);
}

}  // namespace fringetwin::cli
