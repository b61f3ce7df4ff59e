// SPDX-License-Identifier: Apache-2.0
// study: many virtual measurements over a design, resumed where they stopped.
#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/out_folder.hpp"
#include "cli/study_runs.hpp"
#include "study/local_engine.hpp"
#include "study/worker.hpp"

namespace fringetwin::cli {
namespace {

struct StudyCommand {
  std::string study, out;
  bool figures = false;
  study::LocalOptions engine;
};

int run_study(const StudyCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  study::LocalEngine engine(o.engine);
  const StudyRun run{study::load_study(o.study), o.out, &engine, invocation.argv, o.figures};
  if (run.file.volume_map) return run_volume_map(run);
  if (run.file.optimise) return run_optimise(run);
  return run.file.monte_carlo ? run_monte_carlo(run) : run_design(run);
}

}  // namespace

void add_study(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<StudyCommand>();
  CLI::App* sub = app.add_subcommand(
      "study",
      "Many virtual measurements: varies keys of a twin over a design and records results; run again, "
      "it goes on where it stopped");
  sub->add_option("study", o->study, "The STUDY.toml")->required();
  sub->add_option("--out", o->out, "Folder for study.db, study.csv and report.html")->required();
  sub->add_option("--jobs", o->engine.jobs, "Points at a time; default: one per core")
      ->check(CLI::Range(1, 1024));
  sub->add_option("--device", o->engine.device, "A part of a Vulkan device's name");
  sub->add_flag("--figures", o->figures, "Write the report's drawings as SVG files, too (DIR/figures)");
  sub->callback([o, &invocation] {
    // The program itself, also when its file is replaced while the study runs.
    o->engine.worker = {"/proc/self/exe", "study-worker"};
    invocation.run = [o, &invocation] { return run_study(*o, invocation); };
  });

  CLI::App* worker = app.add_subcommand("study-worker", "Runs points for `study`");
  worker->group("");  // not for people
  worker->callback([&invocation] { invocation.run = [] { return study::run_worker(); }; });
}

}  // namespace fringetwin::cli
