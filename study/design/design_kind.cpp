// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "design": every point of a grid, list, Latin hypercube or Sobol design is simulated
// and measured.
#include <fmt/format.h>

#include <algorithm>

#include "study/design/design_plan.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

class DesignKind final : public Kind {
 public:
  DesignKind(const StudyHead& head, const DesignPlan& plan)
      : head_(head), plan_(plan), points_(design_points(plan)) {}

  PointSequence plan() override { return points_; }
  PointTask task() const override { return {head_.twin, head_.records}; }

  void run(KeptPoints& kept) override {
    const KeptPoints::Planned planned = kept.plan(points_);
    say(fmt::format("study \"{}\": {}, {} different traces{}", head_.name, points_text(points_.size()),
                    count_groups(planned.points),
                    planned.done.empty() ? "" : fmt::format("; {} done before", planned.done.size())));
    kept.run(planned);
  }
  std::optional<std::size_t> points_in_all() const override { return points_.size(); }

  bool has_result() const override { return false; }
  StudyReport report(const StudyRecord& study) const override { return design_report(study, plan_); }

  std::string tell(const StudyRecord& study, const EngineSummary& summary) const override {
    const auto done = std::ranges::count(study.rows, PointStatus::done, &StoredPoint::status),
               failed = std::ranges::count(study.rows, PointStatus::failed, &StoredPoint::status);
    return fmt::format("study \"{}\": {} measured, {} failed, {} of them in this run\n", head_.name, done,
                       failed, summary.finished);
  }

 private:
  const StudyHead& head_;
  DesignPlan plan_;
  PointSequence points_;
};

}  // namespace

std::unique_ptr<Kind> make_kind(const StudyHead& head, const DesignPlan& plan) {
  return std::make_unique<DesignKind>(head, plan);
}

}  // namespace fringetwin::study
