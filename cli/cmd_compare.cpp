// SPDX-License-Identifier: Apache-2.0
// compare: measure two capture sets and compare them.

#include "cli/commands.hpp"
#include "cli/extra_file_flags.hpp"
#include "cli/option_groups.hpp"
#include "cli/tell/json_output.hpp"
#include "cli/tell/tell_comparison.hpp"
#include "cli/twin_argument.hpp"
#include "cosim/compare_captures.hpp"
#include "cosim/write_results.hpp"
#include "twin/base/out_folder.hpp"

namespace fringetwin::cli {
namespace {

struct CompareCommand {
  std::string twin, real, sim, out;
  cosim::ExtraFiles extra;
  bool json = false;
};

int run_compare(const CompareCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  cosim::Run run = cosim::measure_both({o.twin, o.real, o.sim});
  const cosim::Origin origin{invocation.argv, version_string()};
  const int code =
      tell_comparison(o.out, run, cosim::compare_and_write(o.out, run, origin, o.extra), invocation.argv);
  print_json_if(o.json, std::filesystem::path(o.out) / "result.json");
  return code_with_figures(o.extra.figures, o.out, code);
}

}  // namespace

void add_compare(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<CompareCommand>();
  CLI::App* sub = app.add_subcommand("compare", "Measure two capture sets and compare them");
  add_twin_argument(*sub, options->twin, "The twin.toml")->required();
  begin_group(*sub, kInput);
  sub->add_option("--real", options->real, "Capture set of the rig")->type_name("DIR")->required();
  sub->add_option("--sim", options->sim, "Capture set of the twin")->type_name("DIR")->required();
  begin_group(*sub, kOutput);
  sub->add_option("--out", options->out, "Folder for result.json, report.html and the maps")
      ->type_name("DIR")
      ->required();
  add_npz_flag(*sub, options->extra);
  add_figures_flag(*sub, options->extra);
  add_json_flag(*sub, options->json, "result.json");
  run_when_chosen(*sub, invocation, options, run_compare);
}

}  // namespace fringetwin::cli
