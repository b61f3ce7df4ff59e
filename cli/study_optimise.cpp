// SPDX-License-Identifier: Apache-2.0
// study, kind = "optimise": the settings with which a number is least uncertain.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "cli/study_runs.hpp"
#include "cli/version.hpp"
#include "study/engine/kept_points.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

std::string values_text(const study::Settings& values) {
  std::vector<std::string> parts;
  for (const auto& [key, text] : values) parts.push_back(key + " = " + text);
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// "7", "1 ... 30"
std::string batch_text(const std::vector<study::StudyPoint>& batch, std::size_t trials) {
  const auto first = static_cast<std::size_t>(batch.front().id) / trials + 1, n = batch.size() / trials;
  return n == 1 ? fmt::format("{}", first) : fmt::format("{} ... {}", first, first + n - 1);
}

void tell_evaluation(const char* what, const study::Evaluation& e) {
  fmt::print("{} {:.4g} +- {:.2g}{}: {}\n", what, e.objective.value, e.objective.sigma,
             std::isnan(e.time_s) ? "" : fmt::format(", {:g} s", e.time_s), values_text(e.values));
}

}  // namespace

int run_optimise(const StudyRun& o) {
  const study::StudyFile& file = o.file;
  study::OptimisePlan plan = file.optimise.value().plan;
  const study::StudyIdentity identity = study::check_study(file, study::optimise_samples(plan));
  plan.inputs = study::complete_inputs({plan.inputs, file.optimise->calibration}, file.twin);
  const auto opened = open_store(o, identity, {"report.html", "study.csv", "result.json"});
  study::StudyStore& store = *opened;
  say(fmt::format("study \"{}\": at most {} evaluations of {} trials", file.name, plan.evaluations,
                  plan.trials));
  study::KeptPoints points({file.twin, file.records, true, plan.inputs.calibration > 0}, *o.engine, store);
  const study::OptimiseResult result = run_until_stopped(store, [&] {
    return study::run_optimise(plan, [&](const std::vector<study::StudyPoint>& batch) {
      say(fmt::format("evaluation {} of at most {}", batch_text(batch, plan.trials), plan.evaluations));
      return points.run(batch);
    });
  });
  const auto rows = store.rows();
  write_text_file(o.out / "study.csv", study::study_csv(rows));
  write_text_file(o.out / "result.json", study::optimise_json(plan, result));
  fmt::print("study \"{}\": {} evaluations, {} in this run\n", file.name, result.evaluations.size(),
             points_text(static_cast<std::int64_t>(points.summary().finished)));
  if (result.best) tell_evaluation("best", result.evaluations[*result.best]);
  for (const std::size_t i : result.front)
    if (i != result.best) tell_evaluation("quicker", result.evaluations[i]);
  tell_traces(points.summary());
  tell_failures(file.file, rows);
  say("result: " + (o.out / "result.json").string());
  write_report(o, study::optimise_report({file, rows, identity, o.argv, version_string()}, plan, result));
  if (result.best) return static_cast<int>(ExitCode::ok);
  warn("nothing that was tried meets all constraints: see result.json");
  return static_cast<int>(ExitCode::no_convergence);
}

}  // namespace fringetwin::cli
