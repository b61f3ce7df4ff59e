// SPDX-License-Identifier: Apache-2.0
// study: many virtual measurements over a design, resumed where they stopped.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <sstream>

#include "cli/commands.hpp"
#include "cli/extra_file_flags.hpp"
#include "cli/option_groups.hpp"
#include "cli/tell/json_output.hpp"
#include "study/engine/local_engine.hpp"
#include "study/engine/worker.hpp"
#include "study/kind/run_study.hpp"
#include "study/slurm/shard_task.hpp"
#include "study/slurm/slurm.hpp"
#include "study/slurm/slurm_engine.hpp"
#include "study/study_file.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/safe_file.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

struct StudyCommand {
  std::string study, out, engine = "local", device;
  bool figures = false, json = false, so_far = false;
  int jobs = 0;
  // of --engine slurm
  int shards = 0;
  std::string slurm_args, slurm_dir;
};

/// The program itself, also when its file is replaced while the study runs; it reads the same files.
std::vector<std::string> worker_command() {
  std::vector<std::string> command{"/proc/self/exe", "study-worker"};
  if (const double limits = file_limits_factor(); limits != 1.0)
    command.insert(command.end(), {"--limits", fmt::format("{}", limits)});
  return command;
}

std::unique_ptr<study::Engine> make_engine(const StudyCommand& o) {
  if (o.engine == "local") {
    if (o.shards > 0 || !o.slurm_args.empty() || !o.slurm_dir.empty())
      throw UserError(ExitCode::usage, "--engine local", "has no --shards, --slurm-args and --slurm-dir",
                      "add --engine slurm, or leave them out");
    return std::make_unique<study::LocalEngine>(study::LocalOptions{worker_command(), o.jobs, o.device});
  }
  study::SlurmOptions slurm;
  slurm.folder = tidy_path(o.slurm_dir.empty() ? fs::path(o.out) / "slurm" : fs::path(o.slurm_dir));
  slurm.program = fs::read_symlink("/proc/self/exe");  // where the nodes find it
  slurm.version = version_string();
  slurm.device = o.device;
  slurm.jobs = std::max(1, o.jobs);
  slurm.shards = o.shards;
  std::istringstream words(o.slurm_args);
  for (std::string word; words >> word;) {
    if (const std::string own = study::slurm::own_option(word); !own.empty())
      throw UserError(ExitCode::usage, "--slurm-args", own + " is set by the program itself", "leave it out");
    slurm.arguments.push_back(word);
  }
  return std::make_unique<study::SlurmEngine>(std::move(slurm));
}

int run_study(const StudyCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  const study::StudyFile file = study::load_study(o.study);
  // nothing runs, so there need be nothing to run on
  const auto engine = o.so_far ? std::make_unique<study::LocalEngine>(study::LocalOptions{}) : make_engine(o);
  const study::StudyRun run{o.out,           *engine,
                            invocation.argv, version_string(),
                            o.figures,       [](const std::string& text) { fmt::print("{}", text); },
                            o.json};
  const auto kind = study::kind_of(file);
  if (o.so_far) return static_cast<int>(study::show_study_so_far(*kind, file.head, run));
  const ExitCode code = study::run_study(*kind, file.head, run);
  return code_with_figures(o.figures, o.out, static_cast<int>(code));
}

}  // namespace

void add_study(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<StudyCommand>();
  CLI::App* sub = app.add_subcommand("study",
                                     "Many virtual measurements: varies keys of a twin over a design and "
                                     "records results; run again, it goes on where it stopped");
  sub->add_option("study", o->study, "The STUDY.toml")->type_name("STUDY.toml")->required();
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for study.db, study.csv and report.html")
      ->type_name("DIR")
      ->required();
  CLI::Option* figures =
      sub->add_flag("--figures", o->figures, "Write the report's drawings as SVG files, too (DIR/figures)");
  sub->add_flag("--so-far", o->so_far,
                "Run nothing: show what has finished (unfinished.csv; of Monte Carlo also unfinished.html)")
      ->excludes(figures);
  add_json_flag(*sub, o->json, "result.json (of a design: the table of its points)");
  begin_group(*sub, kComputing);
  sub->add_option("--engine", o->engine,
                  "local: this machine; slurm: job arrays of a cluster (docs/CLUSTER.md)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  sub->add_option("--jobs", o->jobs, "Points at a time; slurm: of a task, a core each")
      ->type_name("N")
      ->check(CLI::Range(1, 1024))
      ->default_str("one per core; slurm: 1");
  sub->add_option("--device", o->device, "A part of a Vulkan device's name")
      ->type_name("NAME")
      ->default_str("FRINGETWIN_DEVICE, else the CPU");
  begin_group(*sub, "Slurm");
  sub->add_option("--shards", o->shards, "Tasks of an array")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->default_str("one per 16 points, at most 64");
  sub->add_option("--slurm-args", o->slurm_args,
                  "Further arguments of sbatch, \"--partition=long --time=4:00:00\"")
      ->type_name("WORDS");
  sub->add_option("--slurm-dir", o->slurm_dir, "Folder on a disk that the nodes share")
      ->type_name("DIR")
      ->default_str("slurm in --out");
  run_when_chosen(*sub, invocation, o, run_study);

  CLI::App* worker = app.add_subcommand("study-worker", "Runs points for `study`");
  worker->group("");  // not for people
  worker->callback([&invocation] { invocation.run = [] { return study::run_worker(); }; });

  auto task = std::make_shared<study::ShardTask>();
  CLI::App* shard = app.add_subcommand("study-shard", "A task of `study --engine slurm`");
  shard->group("");
  shard->add_option("round", task->round)->type_name("N")->required();
  shard->add_option("index", task->index)->type_name("N")->required();
  shard->callback([task, &invocation] {
    task->version = version_string();
    invocation.run = [task] {
      task->worker = worker_command();
      study::run_shard(*task);
      return static_cast<int>(ExitCode::ok);
    };
  });
}

}  // namespace fringetwin::cli
