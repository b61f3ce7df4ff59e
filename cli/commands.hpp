// SPDX-License-Identifier: Apache-2.0
// Declares one function per subcommand, which adds it to the program; nothing outside cli/ parses arguments.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "cli/version.hpp"

namespace fringetwin::cli {

/// What main() runs after parsing, and the facts every result records.
struct Invocation {
  std::vector<std::string> argv;
  std::function<int()> run;  ///< set by the chosen subcommand; returns the exit code
};

/// Makes `work`, with the options as they were parsed, what main() runs when the subcommand is chosen. `work`
/// takes the options, and the invocation behind them where it needs it.
template <class Options, class Work>
void run_when_chosen(CLI::App& sub, Invocation& invocation, const std::shared_ptr<Options>& options,
                     Work work) {
  sub.callback([options, work, &invocation] {
    invocation.run = [options, work, &invocation] {
      if constexpr (std::is_invocable_v<Work, Options&, const Invocation&>)
        return work(*options, invocation);
      else
        return work(*options);
    };
  });
}

void add_cosim(CLI::App& app, Invocation& invocation);
void add_render(CLI::App& app, Invocation& invocation);
void add_measure(CLI::App& app, Invocation& invocation);
void add_compare(CLI::App& app, Invocation& invocation);
void add_diff(CLI::App& app, Invocation& invocation);
void add_export(CLI::App& app, Invocation& invocation);
void add_open(CLI::App& app, Invocation& invocation);
void add_index(CLI::App& app, Invocation& invocation);
void add_import(CLI::App& app, Invocation& invocation);
void add_new(CLI::App& app, Invocation& invocation);
void add_import_captures(CLI::App& import, Invocation& invocation);  ///< of `import`
void add_needs(CLI::App& app, Invocation& invocation);
void add_calibrate(CLI::App& app, Invocation& invocation);
void add_pareto(CLI::App& app, Invocation& invocation);
void add_study(CLI::App& app, Invocation& invocation);
void add_photometry(CLI::App& app, Invocation& invocation);
void add_capture(CLI::App& app, Invocation& invocation);
void add_help(CLI::App& app, Invocation& invocation);
void add_version(CLI::App& app, Invocation& invocation);
void add_man(CLI::App& app, Invocation& invocation);
void add_completions(CLI::App& app, Invocation& invocation);
void add_info(CLI::App& app, Invocation& invocation);

}  // namespace fringetwin::cli
