// SPDX-License-Identifier: Apache-2.0
// study, kind = "volume-map": a sphere at a lattice of positions.
#include <fmt/format.h>

#include "cli/study_runs.hpp"
#include "cli/version.hpp"
#include "study/engine/kept_points.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

std::string place_text(const Eigen::Vector3d& p) {
  return fmt::format("({:g}, {:g}, {:g})", p.x(), p.y(), p.z());
}

void tell_map(const study::VolumeMap& map) {
  for (const auto& [name, worst] : map.worst) {
    const study::MapPosition &mean = map.positions[worst.mean], &sigma = map.positions[worst.sigma];
    fmt::print("{}: mean {:.3g} at {}, sigma {:.3g} at {}\n", name, mean.numbers.at(name).mean,
               place_text(mean.center_mm), sigma.numbers.at(name).sigma, place_text(sigma.center_mm));
  }
  if (map.largest_mm.n > 0)
    fmt::print(
        "largest spacing error of a trial: {:.3g} mm, {:.3g} ... {:.3g}, of {} trials with all pairs\n",
        map.largest_mm.mean, map.largest_mm.interval.low, map.largest_mm.interval.high, map.largest_mm.n);
  if (!map.worst_spacing) return;
  const auto tell = [&](const char* what, std::size_t i, double value) {
    const study::MapSpacing& s = map.spacings[i];
    fmt::print("spacing: {} {:.3g} mm between {} and {} ({:.4g} mm)\n", what, value,
               place_text(map.positions[s.a].center_mm), place_text(map.positions[s.b].center_mm),
               s.length_mm);
  };
  tell("mean error", map.worst_spacing->mean, map.spacings[map.worst_spacing->mean].error_mm.mean);
  tell("sigma", map.worst_spacing->sigma, map.spacings[map.worst_spacing->sigma].error_mm.sigma);
}

}  // namespace

int run_volume_map(const StudyRun& o) {
  const study::StudyFile& file = o.file;
  study::VolumeMapPlan plan = file.volume_map.value().plan;
  plan.inputs = study::complete_inputs({plan.inputs, file.volume_map->calibration}, file.twin);
  const std::vector<study::StudyPoint> points = study::volume_map_points(plan);
  const study::StudyIdentity identity = study::check_study(file, points);
  const auto opened = open_store(o, identity, {"report.html", "study.csv", "result.json"});
  study::StudyStore& store = *opened;
  say(fmt::format("study \"{}\": {} positions, {} trials", file.name, points.size() / plan.trials,
                  plan.trials));
  study::KeptPoints kept({file.twin, file.records, true, plan.inputs.calibration > 0}, *o.engine, store);
  const auto outcomes = run_until_stopped(store, [&] { return kept.run(points); });
  const auto rows = store.rows();
  const study::VolumeMap map = study::volume_map(plan, outcomes);
  write_text_file(o.out / "study.csv", study::study_csv(rows));
  write_text_file(o.out / "result.json", study::volume_map_json(plan, map));
  fmt::print("study \"{}\": {} of {} positions measured in all {} trials, {} in this run\n", file.name,
             map.measured, map.positions.size(), plan.trials,
             points_text(static_cast<std::int64_t>(kept.summary().finished)));
  tell_map(map);
  tell_traces(kept.summary());
  tell_failures(file.file, rows);
  say("result: " + (o.out / "result.json").string());
  write_report(o, study::volume_map_report({file, rows, identity, o.argv, version_string()}, plan, map));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace fringetwin::cli
