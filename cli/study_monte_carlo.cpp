// SPDX-License-Identifier: Apache-2.0
// study, kind = "monte-carlo": trials until the numbers are known well enough.
#include <fmt/format.h>

#include "cli/study_runs.hpp"
#include "cli/version.hpp"
#include "study/engine/kept_points.hpp"
#include "study/monte_carlo/monte_carlo_run.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

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

/// What comes next: a block of trials or, after the last one, the points of the Sobol indices.
std::string batch_text(const std::vector<study::StudyPoint>& batch, const study::MonteCarloPlan& plan) {
  const std::int64_t first = batch.front().id, last = batch.back().id;
  if (static_cast<std::size_t>(first) >= plan.most_trials)
    return fmt::format("{} for the shares of the inputs",
                       points_text(static_cast<std::int64_t>(batch.size())));
  return fmt::format("trials {} ... {} of at most {}", first + 1, last + 1, plan.most_trials);
}

}  // namespace

int run_monte_carlo(const StudyRun& o) {
  const study::StudyFile& file = o.file;
  const study::MonteCarloPlan plan = study::complete_plan(file);
  const study::StudyIdentity identity =
      study::check_study(file, {study::StudyPoint{}, study::first_trial(file)});
  const auto opened = open_store(o, identity, {"report.html", "study.csv", "result.json"});
  study::StudyStore& store = *opened;
  say(fmt::format("study \"{}\": blocks of {} trials, at most {}", file.name, plan.rule.trials_per_block(),
                  plan.most_trials));
  study::KeptPoints points(study::monte_carlo_task(file, plan), *o.engine, store);
  const study::MonteCarloResult result = run_until_stopped(store, [&] {
    return study::run_monte_carlo(plan, [&](const std::vector<study::StudyPoint>& batch) {
      say(batch_text(batch, plan));
      return points.run(batch);
    });
  });
  const auto rows = store.rows();
  write_text_file(o.out / "study.csv", study::study_csv(rows));
  write_text_file(o.out / "result.json", study::monte_carlo_json(plan, result));
  fmt::print("study \"{}\": {} trials, {} failed, {} in this run\n", file.name, result.trials, result.failed,
             points_text(static_cast<std::int64_t>(points.summary().finished)));
  for (const auto& [name, number] : result.numbers) tell_number(name, number, result, plan.rule.coverage);
  tell_traces(points.summary());
  tell_failures(file.file, rows);
  say("result: " + (o.out / "result.json").string());
  write_report(o, study::monte_carlo_report({file, rows, identity, o.argv, version_string()}, plan, result));
  if (result.converged) return static_cast<int>(ExitCode::ok);
  warn(fmt::format("not converged after {} trials: give more most_trials or fewer digits", result.trials));
  return static_cast<int>(ExitCode::no_convergence);
}

}  // namespace fringetwin::cli
