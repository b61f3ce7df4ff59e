// SPDX-License-Identifier: Apache-2.0
// study: many virtual measurements over a design, resumed where they stopped.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <set>

#include "cli/commands.hpp"
#include "cli/out_folder.hpp"
#include "cli/version.hpp"
#include "study/design.hpp"
#include "study/local_engine.hpp"
#include "study/monte_carlo_local.hpp"
#include "study/study_file.hpp"
#include "study/study_store.hpp"
#include "study/trace_share.hpp"
#include "study/worker.hpp"
#include "twin/errors.hpp"
#include "twin/image_io.hpp"
#include "twin/progress.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_reasons = 5;

struct StudyCommand {
  std::string study, out;
  study::LocalOptions engine;
};

std::string points_text(std::int64_t n) { return fmt::format("{} point{}", n, n == 1 ? "" : "s"); }

// The reasons of what failed, each once. A study without a result is no success.
void tell_failures(const fs::path& file, const std::vector<study::StoredPoint>& rows) {
  std::set<std::string> reasons;
  bool any_done = false;
  for (const study::StoredPoint& row : rows) {
    if (row.status == study::PointStatus::failed) reasons.insert(row.outcome.reason);
    any_done = any_done || row.status == study::PointStatus::done;
  }
  if (!any_done && !reasons.empty())
    throw UserError(ExitCode::usage, file.string(), "no point could be measured: " + *reasons.begin());
  std::size_t told = 0;
  for (const std::string& reason : reasons) {
    if (++told > most_reasons) break;
    warn("points failed: " + reason);
  }
}

// "radius 19.0031, sigma 0.0054, 95 %: 18.9919 ... 19.0131; depth 0.82, noise 0.20"
void tell_number(const std::string& name, const study::MonteCarloNumber& n,
                 const study::MonteCarloResult& result, double coverage) {
  const study::SampleSummary& s = n.summary;
  fmt::print("{} {:.8g}, sigma {:.3g}, {:g} %: {:.8g} ... {:.8g}", name, s.mean, s.sigma, 100.0 * coverage,
             s.symmetric.low, s.symmetric.high);
  for (std::size_t f = 0; f < n.sensitivity.total.size(); ++f)
    fmt::print("{} {} {:.2f}", f == 0 ? "; total effects:" : ",", result.factors[f],
               n.sensitivity.total[f].value);
  fmt::print("{}\n", n.convergence.reached ? "" : " (not converged)");
}

int run_monte_carlo(const StudyCommand& o, const study::StudyFile& file) {
  const study::MonteCarloPlan plan = study::complete_plan(file);
  const study::StudyIdentity identity =
      study::check_study(file, {study::StudyPoint{}, study::first_trial(file)});
  const fs::path dir = o.out;
  begin_output(dir, {"study.csv", "result.json"});
  study::StudyStore store(dir / "study.db", identity, version_string());
  say(fmt::format("study \"{}\": blocks of {} trials, at most {}", file.name, plan.rule.trials_per_block(),
                  plan.most_trials));
  study::LocalSummary summary;
  study::MonteCarloResult result;
  try {
    result = study::run_monte_carlo_local(file, plan, store, o.engine, &summary);
  } catch (const Cancelled&) {
    const auto counts = store.counts();
    say(fmt::format("stopped after {}; the same command goes on from there",
                    points_text(counts.done + counts.failed)));
    throw;
  }
  const auto rows = store.rows();
  write_text_file(dir / "study.csv", study::study_csv(rows));
  write_text_file(dir / "result.json", study::monte_carlo_json(plan, result));
  fmt::print("study \"{}\": {} trials, {} failed, {} in this run\n", file.name, result.trials, result.failed,
             points_text(static_cast<std::int64_t>(summary.finished)));
  for (const auto& [name, number] : result.numbers) tell_number(name, number, result, plan.rule.coverage);
  tell_failures(o.study, rows);
  say("result: " + (dir / "result.json").string());
  if (result.converged) return static_cast<int>(ExitCode::ok);
  warn(fmt::format("not converged after {} trials: give more most_trials or fewer digits", result.trials));
  return static_cast<int>(ExitCode::no_convergence);
}

int run_study(const StudyCommand& o) {
  check_out_folder(o.out);
  const study::StudyFile file = study::load_study(o.study);
  if (file.monte_carlo) return run_monte_carlo(o, file);
  const std::vector<study::StudyPoint> points = study::design_points(file);
  const study::StudyIdentity identity = study::check_study(file, points);
  const fs::path dir = o.out;
  begin_output(dir, {"study.csv"});
  study::StudyStore store(dir / "study.db", identity, version_string());
  store.add(points);

  std::set<std::int64_t> done;
  for (const study::StudyPoint& p : points) done.insert(p.id);
  for (const study::StudyPoint& p : store.pending()) done.erase(p.id);
  const auto plan = study::plan_traces(file.twin, points);
  const auto n = static_cast<std::int64_t>(points.size());
  say(fmt::format("study \"{}\": {}, {} different traces{}", file.name, points_text(n),
                  study::count_groups(plan),
                  done.empty() ? "" : fmt::format("; {} done before", done.size())));

  const study::PointTask task{file.twin, file.records};
  study::LocalSummary summary;
  try {
    summary = study::run_local(task, plan, done, o.engine,
                               [&](const study::PointOutcome& outcome) { store.record({outcome}); });
  } catch (const Cancelled&) {
    const auto counts = store.counts();
    say(fmt::format("stopped with {} of {} finished; the same command goes on from there",
                    counts.done + counts.failed, points_text(n)));
    throw;
  }
  const auto rows = store.rows();
  write_text_file(dir / "study.csv", study::study_csv(rows));
  const auto counts = store.counts();
  fmt::print("study \"{}\": {} measured, {} failed, {} of them in this run\n", file.name, counts.done,
             counts.failed, summary.finished);
  fmt::print("light traced for {} of {}: {} traces saved\n", summary.traced,
             points_text(static_cast<std::int64_t>(summary.finished)), summary.finished - summary.traced);
  tell_failures(o.study, rows);
  say("table: " + (dir / "study.csv").string());
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

void add_study(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<StudyCommand>();
  CLI::App* sub = app.add_subcommand(
      "study",
      "Many virtual measurements: varies keys of a twin over a design and records results; run again, "
      "it goes on where it stopped");
  sub->add_option("study", o->study, "The STUDY.toml")->required();
  sub->add_option("--out", o->out, "Folder for study.db and study.csv")->required();
  sub->add_option("--jobs", o->engine.jobs, "Points at a time; default: one per core")
      ->check(CLI::Range(1, 1024));
  sub->add_option("--device", o->engine.device, "A part of a Vulkan device's name");
  sub->callback([o, &invocation] {
    // The program itself, also when its file is replaced while the study runs.
    o->engine.worker = {"/proc/self/exe", "study-worker"};
    invocation.run = [o] { return run_study(*o); };
  });

  CLI::App* worker = app.add_subcommand("study-worker", "Runs points for `study`");
  worker->group("");  // not for people
  worker->callback([&invocation] { invocation.run = [] { return study::run_worker(); }; });
}

}  // namespace fringetwin::cli
