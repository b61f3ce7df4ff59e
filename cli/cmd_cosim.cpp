// SPDX-License-Identifier: Apache-2.0
// cosim: render, measure both, compare, report.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/extra_file_flags.hpp"
#include "cli/option_groups.hpp"
#include "cli/render_flags.hpp"
#include "cli/tell/json_output.hpp"
#include "cli/tell/tell_comparison.hpp"
#include "cli/twin_argument.hpp"
#include "compare/refine/asked_parameters.hpp"
#include "cosim/cosim.hpp"
#include "cosim/refined_into_twin.hpp"
#include "cosim/write_results.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

struct CosimCommand {
  std::string twin, out, into;
  cosim::CosimRequest request;
  cosim::ExtraFiles extra;
  bool radiance = false, json = false;
};

int run_cosim(CosimCommand& o, const Invocation& invocation) {
  if (o.request.render.device == "list") return print_devices();
  if (o.twin.empty() || o.out.empty())
    throw UserError(ExitCode::usage, "cosim", "a twin and --out are needed",
                    "fringetwin cosim TWIN.toml --out DIR");
  check_out_folder(o.out);
  o.request.twin = o.twin;
  o.request.into = o.into;
  cosim::Run run = cosim::run_cosim(o.request);
  say(fmt::format("simulated measurement of {} images: render {:.2f} s + measure {:.2f} s on {}",
                  run.simulated.images.size() * run.simulated.images.front().images.size(),
                  run.timer.seconds["render"], run.timer.seconds["measure_simulated"], run.rendering.device));
  cosim::write_simulated_side(o.out, run, o.radiance);
  const cosim::Origin origin{invocation.argv, version_string()};
  const int code =
      tell_comparison(o.out, run, cosim::compare_and_write(o.out, run, origin, o.extra), invocation.argv);
  if (!o.into.empty()) cosim::put_refined_into_twin(o.out, run, o.into);
  print_json_if(o.json, std::filesystem::path(o.out) / "result.json");
  return code_with_figures(o.extra.figures, o.out, code);
}

}  // namespace

void add_cosim(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<CosimCommand>();
  CLI::App* sub = app.add_subcommand("cosim", "The main job: render, measure both, compare, report");
  add_twin_argument(*sub, options->twin, "The twin.toml");
  begin_group(*sub, kOutput);
  sub->add_option("--out", options->out,
                  "Folder for result.json, report.html, maps and the simulated capture set")
      ->type_name("DIR");
  sub->add_flag("--radiance", options->radiance, "Also write float32 EXR images (E before the sensor)");
  add_npz_flag(*sub, options->extra);
  add_figures_flag(*sub, options->extra);
  add_json_flag(*sub, options->json, "result.json");
  begin_group(*sub, kComparison);
  sub->add_option("--steps", options->request.steps, "Compare every second phase step only")
      ->type_name("NAME")
      ->check(CLI::IsMember({"even", "odd"}))
      ->default_str("all");
  sub->add_option("--hold-out", options->request.hold_out,
                  "Deal the phase steps to K folds and predict each from a fit to the others")
      ->type_name("K")
      ->check(CLI::Range(2, 64))
      ->default_str("what the twin's [compare] says, else none");
  sub->add_option("--hold-out-by", options->request.hold_out_by,
                  "Deal whole pitches to those folds, or steps of all")
      ->type_name("NAME")
      ->check(CLI::IsMember({"steps", "pitches"}))
      ->default_str("what the twin's [compare] says, else steps");
  begin_group(*sub, kRefinement);
  sub->add_option("--refine", options->request.refine,
                  "Fit these to the real images first: " + compare::refine_names() +
                      ", or a parameter by its name (projector.k1)")
      ->type_name("NAMES")
      ->delimiter(',');
  add_twin_option(*sub, "--into", options->into,
                  "Put the values that --refine finds into this twin.toml; all its other lines stay");
  add_render_flags(*sub, options->request.render);
  sub->get_option("--seed")->default_str("0; 1 against images that were rendered with 0");
  run_when_chosen(*sub, invocation, options, run_cosim);
}

}  // namespace fringetwin::cli
