// SPDX-License-Identifier: Apache-2.0
// Declares one function per subcommand, which adds it to the program; nothing outside cli/ parses arguments.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace fringetwin::cli {

/// What main() runs after parsing, and the facts every result records.
struct Invocation {
  std::vector<std::string> argv;
  std::function<int()> run;  ///< set by the chosen subcommand; returns the exit code
};

void add_cosim(CLI::App& app, Invocation& invocation);
void add_render(CLI::App& app, Invocation& invocation);
void add_measure(CLI::App& app, Invocation& invocation);
void add_compare(CLI::App& app, Invocation& invocation);
void add_diff(CLI::App& app, Invocation& invocation);
void add_import(CLI::App& app, Invocation& invocation);
void add_import_captures(CLI::App& import, Invocation& invocation);  ///< of `import`
void add_needs(CLI::App& app, Invocation& invocation);
void add_calibrate(CLI::App& app, Invocation& invocation);
void add_pareto(CLI::App& app, Invocation& invocation);
void add_study(CLI::App& app, Invocation& invocation);
void add_photometry(CLI::App& app, Invocation& invocation);
void add_capture(CLI::App& app, Invocation& invocation);
void add_info(CLI::App& app, Invocation& invocation);

}  // namespace fringetwin::cli
