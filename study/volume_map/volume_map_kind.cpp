// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "volume-map": a sphere is measured at a lattice of positions in every trial, and the
// outcomes become result.json, the page and the lines on the terminal.
#include <fmt/format.h>

#include "study/uncertain/uncertain_file.hpp"
#include "study/volume_map/volume_map_file.hpp"
#include "study/volume_map/volume_map_report.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

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

  std::vector<StudyPoint> plan() override {
    plan_.inputs = complete_inputs({plan_.inputs, plan_.calibration}, head_.twin);
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
  std::vector<StudyPoint> points_;
  VolumeMap map_;
};

}  // namespace

std::unique_ptr<Kind> make_kind(const StudyHead& head, const VolumeMapPlan& plan) {
  return std::make_unique<VolumeMapKind>(head, plan);
}

}  // namespace fringetwin::study
