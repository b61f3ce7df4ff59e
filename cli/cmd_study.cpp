// SPDX-License-Identifier: Apache-2.0
// study: many virtual measurements over a design, resumed where they stopped.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "cli/commands.hpp"
#include "study/worker.hpp"
#include "twin/errors.hpp"
#include "twin/progress.hpp"

namespace fringetwin::cli {

void add_study(CLI::App& app, Invocation& invocation) {
  CLI::App* worker = app.add_subcommand("study-worker", "Runs points for `study`");
  worker->group("");  // not for people
  worker->callback([&invocation] { invocation.run = [] { return study::run_worker(); }; });
}

}  // namespace fringetwin::cli
