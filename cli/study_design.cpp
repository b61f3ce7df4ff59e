// SPDX-License-Identifier: Apache-2.0
// study, kind = "design": every point of a grid, list, Latin hypercube or Sobol design.
#include <fmt/format.h>

#include <set>

#include "cli/study_runs.hpp"
#include "cli/version.hpp"
#include "study/design/design.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {

int run_design(const StudyRun& o) {
  const study::StudyFile& file = o.file;
  const std::vector<study::StudyPoint> points = study::design_points(file);
  const study::StudyIdentity identity = study::check_study(file, points);
  const std::filesystem::path& dir = o.out;
  const auto opened = open_store(o, identity, {"report.html", "study.csv"});
  study::StudyStore& store = *opened;
  store.add(points);

  std::set<std::int64_t> done;
  for (const study::StudyPoint& p : points) done.insert(p.id);
  for (const study::StudyPoint& p : store.pending()) done.erase(p.id);
  const auto plan = study::plan_traces(file.twin, points);
  const auto n = static_cast<std::int64_t>(points.size());
  say(fmt::format("study \"{}\": {}, {} different traces{}", file.name, points_text(n),
                  study::count_groups(plan),
                  done.empty() ? "" : fmt::format("; {} done before", done.size())));

  const study::PointTask task{file.twin, file.records, false, false, store.digest()};
  study::EngineSummary summary;
  try {
    summary =
        o.engine->run(task, plan, done, [&](const study::PointOutcome& outcome) { store.record({outcome}); });
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
  tell_traces(summary);
  tell_failures(file.file, rows);
  say("table: " + (dir / "study.csv").string());
  write_report(o, study::design_report({file, rows, identity, o.argv, version_string()}));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace fringetwin::cli
