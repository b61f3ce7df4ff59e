// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "volume-map": a sphere is measured at a lattice of positions in every trial, and the
// outcomes become result.json, the page and the lines on the terminal.
#include <fmt/format.h>

#include <array>

#include "report/json.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "study/volume_map/volume_map.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

using report::Json, report::json_number, report::json_numbers;

Json json(const MapNumber& n) {
  return {{"mean", json_number(n.mean)},
          {"sigma", json_number(n.sigma)},
          {"interval", json_numbers(std::array{n.interval.low, n.interval.high})}};
}

Json json(const MapPosition& p) {
  Json out = {{"center_mm", json_numbers(p.center_mm)}, {"n", p.n}, {"failed", p.failed}};
  if (!p.reason.empty()) out["reason"] = p.reason;
  for (const auto& [name, number] : p.numbers) out[name] = json(number);
  return out;
}

Json json(const MapSpacing& s) {
  return {{"positions", {s.a, s.b}},
          {"length_mm", json_number(s.length_mm)},
          {"n", s.error_mm.n},
          {"error_mm", json(s.error_mm)}};
}

std::string coordinates_text(const Eigen::Vector3d& p) {
  return fmt::format("({:g}, {:g}, {:g})", p.x(), p.y(), p.z());
}

/// Returns lines of text that say where the errors are worst: one for each number, and those of the spacings
/// between positions.
std::string worst_lines(const VolumeMap& map) {
  std::string out;
  for (const auto& [name, worst] : map.worst) {
    const MapPosition &mean = map.positions[worst.mean], &sigma = map.positions[worst.sigma];
    out += fmt::format("{}: mean {:.3g} at {}, sigma {:.3g} at {}\n", name, mean.numbers.at(name).mean,
                       coordinates_text(mean.center_mm), sigma.numbers.at(name).sigma,
                       coordinates_text(sigma.center_mm));
  }
  if (map.largest_mm.n > 0)
    out += fmt::format(
        "largest spacing error of a trial: {:.3g} mm, {:.3g} ... {:.3g}, of {} trials with all pairs\n",
        map.largest_mm.mean, map.largest_mm.interval.low, map.largest_mm.interval.high, map.largest_mm.n);
  if (!map.worst_spacing) return out;
  const auto line = [&](const char* what, std::size_t i, double value) {
    const MapSpacing& s = map.spacings[i];
    return fmt::format("spacing: {} {:.3g} mm between {} and {} ({:.4g} mm)\n", what, value,
                       coordinates_text(map.positions[s.a].center_mm),
                       coordinates_text(map.positions[s.b].center_mm), s.length_mm);
  };
  const MapWorst& worst = *map.worst_spacing;
  return out + line("mean error", worst.mean, map.spacings[worst.mean].error_mm.mean) +
         line("sigma", worst.sigma, map.spacings[worst.sigma].error_mm.sigma);
}

class VolumeMapKind final : public Kind {
 public:
  VolumeMapKind(const StudyHead& head, const VolumeMapPlan& plan) : head_(head), plan_(plan) {}

  PointSequence plan() override {
    plan_.inputs = complete_inputs(plan_, head_.twin);
    points_ = volume_map_points(plan_);
    return points_;
  }
  PointTask task() const override { return {head_.twin, head_.records, true, plan_.inputs.calibration > 0}; }

  void run(KeptPoints& kept) override {
    say(fmt::format("study \"{}\": {} positions, {} trials", head_.name, points_.size() / plan_.trials,
                    plan_.trials));
    map_ = volume_map(plan_, kept.run(points_));
  }

  std::string write() const override { return volume_map_json(plan_, map_); }
  StudyReport report(const StudyRecord& study) const override {
    return volume_map_report(study, plan_, map_);
  }

  std::string tell(const StudyRecord&, const EngineSummary& summary) const override {
    return fmt::format("study \"{}\": {} of {} positions measured in all {} trials, {} in this run\n",
                       head_.name, map_.measured, map_.positions.size(), plan_.trials,
                       points_text(summary.finished)) +
           worst_lines(map_);
  }

 private:
  const StudyHead& head_;
  VolumeMapPlan plan_;
  PointSequence points_;
  VolumeMap map_;
};

}  // namespace

std::string volume_map_json(const VolumeMapPlan& plan, const VolumeMap& map) {
  Json out = {{"schema", "fringetwin-volume-map/1"},
              {"object", plan.object},
              {"radius_mm", plan.radius_mm},
              {"center_mm", json_numbers(plan.center_mm)},
              {"size_mm", json_numbers(plan.size_mm)},
              {"counts", plan.counts},
              {"trials", plan.trials},
              {"coverage", plan.coverage},
              {"seed", plan.seed},
              {"factors", plan.inputs.factors()},
              {"measured", map.measured},
              {"worst", Json::object()},
              {"positions", Json::array()}};
  for (const auto& [name, w] : map.worst) out["worst"][name] = {{"mean_at", w.mean}, {"sigma_at", w.sigma}};
  for (const MapPosition& p : map.positions) out["positions"].push_back(json(p));
  Json spacing = {{"largest_mm", json(map.largest_mm)},
                  {"worst_mean", nullptr},
                  {"worst_sigma", nullptr},
                  {"pairs", Json::array()}};
  spacing["largest_mm"]["n"] = map.largest_mm.n;
  if (map.worst_spacing) {
    spacing["worst_mean"] = map.worst_spacing->mean;
    spacing["worst_sigma"] = map.worst_spacing->sigma;
  }
  for (const MapSpacing& s : map.spacings) spacing["pairs"].push_back(json(s));
  out["spacing"] = std::move(spacing);
  return out.dump(1) + "\n";
}

std::unique_ptr<Kind> make_kind(const StudyHead& head, const VolumeMapPlan& plan) {
  return std::make_unique<VolumeMapKind>(head, plan);
}

}  // namespace fringetwin::study
