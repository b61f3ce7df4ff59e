// SPDX-License-Identifier: Apache-2.0
// diff: two results -> paired differences.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "compare/diff.hpp"

namespace fringetwin::cli {
namespace {

struct DiffCommand {
  std::string a, b;
  bool json = false;
};

}  // namespace

void add_diff(CLI::App& app, Invocation& invocation) {
  auto runs = std::make_shared<DiffCommand>();
  CLI::App* sub = app.add_subcommand("diff", "Two results: paired differences (B - A) on stdout");
  sub->add_option("run_a", runs->a, "Folder of a run, or its result.json")->type_name("RUN_A")->required();
  sub->add_option("run_b", runs->b, "Folder of a run, or its result.json")->type_name("RUN_B")->required();
  begin_group(*sub, kOutput);
  sub->add_flag("--json", runs->json, "Print the differences as JSON");
  run_when_chosen(*sub, invocation, runs, [](const DiffCommand& o) {
    const compare::Differences found = compare::diff_results(o.a, o.b);
    fmt::print("{}", o.json ? compare::differences_json(found) : compare::differences_text(found));
    return 0;
  });
}

}  // namespace fringetwin::cli
