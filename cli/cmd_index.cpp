// SPDX-License-Identifier: Apache-2.0
// index: one page that lists all runs below a folder.
#include <fmt/format.h>

#include <filesystem>

#include "cli/commands.hpp"
#include "compare/run_index.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

int run_index(const std::string& dir, const Invocation& invocation) {
  if (!fs::is_directory(dir))
    throw UserError(ExitCode::input, dir, "is no folder", "give the folder below which runs were written");
  check_out_folder(dir);
  const fs::path page = fs::path(dir) / "index.html";
  const bool there = fs::exists(fs::symlink_status(page));
  if (there && !compare::is_run_index(page))
    throw UserError(ExitCode::usage, page.string(), "was not written by this command, and is not overwritten",
                    "move it away, or give another folder");
  const std::vector<compare::RunSummary> runs = compare::runs_below(dir);
  if (runs.empty() && !there)
    throw UserError(ExitCode::input, dir,
                    "no run is here or below: no result.json, no study and no page of a run",
                    "give the folder below which runs were written (--out of the commands)");
  write_text_file(page, compare::run_index_html(dir, runs, invocation.argv, version_string()));
  say(fmt::format("{} {} listed", runs.size(), runs.size() == 1 ? "run" : "runs"));
  fmt::print("{}\n", plain_text(page.string()));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_index(CLI::App& app, Invocation& invocation) {
  auto dir = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("index", "One page of all runs below a folder: DIR/index.html");
  sub->add_option("dir", *dir, "Folder below which runs were written")->type_name("DIR")->required();
  run_when_chosen(*sub, invocation, dir, run_index);
}

}  // namespace fringetwin::cli
