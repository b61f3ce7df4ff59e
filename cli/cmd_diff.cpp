// SPDX-License-Identifier: Apache-2.0
// diff: two results -> paired differences.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "compare/diff.hpp"

namespace fringetwin::cli {

void add_diff(CLI::App& app, Invocation& invocation) {
  auto runs = std::make_shared<std::pair<std::string, std::string>>();
  CLI::App* sub = app.add_subcommand("diff", "Two results: paired differences (B - A) on stdout");
  sub->add_option("run_a", runs->first, "Folder of a run, or its result.json")
      ->type_name("RUN_A")
      ->required();
  sub->add_option("run_b", runs->second, "Folder of a run, or its result.json")
      ->type_name("RUN_B")
      ->required();
  run_when_chosen(*sub, invocation, runs, [](const std::pair<std::string, std::string>& folders) {
    fmt::print("{}", compare::diff_results(folders.first, folders.second));
    return 0;
  });
}

}  // namespace fringetwin::cli
