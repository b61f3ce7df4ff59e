// SPDX-License-Identifier: Apache-2.0
// Adds the commands `export`, which writes the tables of a result as CSV and the drawings of its page as SVG,
// and `open`, which shows its page.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "compare/result_csv.hpp"
#include "compare/run_page.hpp"
#include "report/plot/page_drawings.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

struct ExportCommand {
  std::string run, out;
  bool figures = false;
};

bool is_page(const fs::path& file) { return file.extension() == ".html" && !fs::is_directory(file); }

/// Returns the page of a run's folder, or the page itself; report.html where the folder has none. Throws
/// UserError(input) of a study that has none yet.
fs::path page_of(const fs::path& run) {
  if (!fs::is_directory(run)) return run;
  const fs::path page = compare::page_in(run);
  if (page.empty() && compare::is_study_folder(run))
    throw UserError(
        ExitCode::input, run.string(), "the study is not finished and has no page yet",
        "of a Monte Carlo study `" +
            report::shell_command({"fringetwin", "study", "STUDY.toml", "--out", run.string(), "--so-far"}) +
            "` makes one");
  return page.empty() ? run / compare::kRunPage : page;
}

/// Returns the page whose drawings are asked for; `run`: a run's folder, its result.json, or the page itself.
fs::path drawn_page(const fs::path& run) {
  return page_of(is_page(run) || fs::is_directory(run) ? run : run.parent_path());
}

/// Returns whether `run` is a page, or a folder that has one beside no result whose tables could be written.
bool has_page_alone(const fs::path& run) {
  if (!fs::is_directory(run)) return is_page(run);
  return compare::is_study_folder(run) ||
         (!fs::exists(run / "result.json") && !compare::page_in(run).empty());
}

std::vector<report::PageDrawing> drawings_of(const fs::path& page) {
  const std::string html = read_whole_text(
      page, {.what = "page", .hint = "give the folder that a run wrote into, or a page (.html)"});
  std::vector<report::PageDrawing> drawings = report::drawings_of_page(html);
  if (drawings.empty()) report::check_all_drawn(page);
  if (drawings.empty())
    throw UserError(ExitCode::input, page.string(), "the page has no drawings",
                    "leave out --figures; maps are PNG files beside the page");
  return drawings;
}

/// All is read before anything is written.
int run_export(const ExportCommand& o) {
  check_out_folder(o.out);
  std::vector<compare::CsvTable> tables;
  std::vector<report::PageDrawing> drawings;
  if (!has_page_alone(o.run))
    tables = compare::result_tables_of(o.run);
  else if (!o.figures)
    throw UserError(
        ExitCode::usage, o.run,
        is_page(o.run) ? "a page has no tables" : "holds no result of cosim, compare or measure",
        is_page(o.run)
            ? "give the folder of its run, or --figures for the page's drawings"
            : std::string("--figures exports the drawings of its page") +
                  (compare::is_study_folder(o.run) ? "; the table of a study is its study.csv" : ""));
  if (o.figures) drawings = drawings_of(drawn_page(o.run));
  begin_output(o.out, {});
  const auto write = [&](const std::string& name, const std::string& text) {
    const fs::path file = fs::path(o.out) / name;
    write_text_file(file, text);
    fmt::print("{}\n", plain_text(file.string()));
  };
  for (const compare::CsvTable& table : tables) write(table.name + ".csv", table.text);
  for (const report::PageDrawing& drawing : drawings) write(drawing.name + ".svg", drawing.svg);
  if (o.figures) report::check_all_drawn(drawn_page(o.run));
  return 0;
}

enum class Started { yes, refused, missing };

/// Starts a program that goes on without this one: in a session of its own, without this one's streams, which
/// a browser would keep open. One that has not ended after two seconds has started.
Started start_by_itself(const char* program, const std::string& argument) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLongest(2000), kPause(20);
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&streams, fd, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string name = program, value = argument;
  char* argv[] = {name.data(), value.data(), nullptr};
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, program, &streams, &attributes, argv, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&streams);
  if (error != 0) return Started::missing;
  int status = 0;
  for (const auto begin = Clock::now(); Clock::now() < begin + kLongest;) {
    if (waitpid(pid, &status, WNOHANG) == pid)
      return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? Started::yes : Started::refused;
    std::this_thread::sleep_for(kPause);
  }
  return Started::yes;
}

int run_open(const std::string& run) {
  const fs::path page = fs::absolute(page_of(run));
  if (!fs::is_regular_file(page) || page.extension() != ".html")
    throw UserError(
        ExitCode::input, page.string(), "there is no such page",
        "give the folder that a run wrote into, or a page (.html); `fringetwin index DIR` makes one "
        "of all runs below a folder");
  fmt::print("{}\n", plain_text(page.string()));
  const Started started = start_by_itself("xdg-open", page.string());
  if (started != Started::yes)
    throw UserError(
        ExitCode::input, "xdg-open",
        started == Started::refused ? "found no program for pages" : "cannot be started (package xdg-utils)",
        "open the page that is named above in a browser");
  return 0;
}

}  // namespace

void add_export(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<ExportCommand>();
  CLI::App* sub = app.add_subcommand("export", "The tables of a result as CSV files, the drawings as SVG");
  sub->add_option("run", options->run, "Folder of a run, its result.json, or a page (with --figures)")
      ->type_name("RUN")
      ->required();
  begin_group(*sub, kOutput);
  sub->add_option("--out", options->out, "Folder for the tables (fits.csv, gain.csv, explained.csv ...)")
      ->type_name("DIR")
      ->required();
  sub->add_flag("--figures", options->figures, "Also the plots of the run's page, as SVG files");
  run_when_chosen(*sub, invocation, options, run_export);
}

void add_open(CLI::App& app, Invocation& invocation) {
  auto run = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("open", "Shows the page of a run in the browser");
  sub->add_option("run", *run, "Folder of a run, or a page (.html)")->type_name("RUN")->required();
  run_when_chosen(*sub, invocation, run, run_open);
}

}  // namespace fringetwin::cli
