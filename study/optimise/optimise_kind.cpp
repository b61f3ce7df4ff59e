// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "optimise": searches for the settings of the rig with which a number is least
// uncertain.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "study/optimise/optimise_file.hpp"
#include "study/optimise/optimise_report.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

/// Returns the numbers of the evaluations in a batch, "7" or "1 ... 30".
std::string evaluations_text(const std::vector<StudyPoint>& batch, std::size_t trials) {
  const auto first = static_cast<std::size_t>(batch.front().id) / trials + 1, n = batch.size() / trials;
  return n == 1 ? fmt::format("{}", first) : fmt::format("{} ... {}", first, first + n - 1);
}

/// Returns "best 0.0021 +- 0.0003, 0.36 s: projector.intensity = 40"
std::string evaluation_line(const char* what, const Evaluation& e) {
  std::vector<std::string> values;
  for (const auto& [key, text] : e.values) values.push_back(key + " = " + text);
  return fmt::format("{} {:.4g} +- {:.2g}{}: {}\n", what, e.objective.value, e.objective.sigma,
                     std::isnan(e.time_s) ? "" : fmt::format(", {:g} s", e.time_s), fmt::join(values, ", "));
}

class OptimiseKind final : public Kind {
 public:
  OptimiseKind(const StudyHead& head, const OptimisePlan& plan) : head_(head), plan_(plan) {}

  std::vector<StudyPoint> plan() override {
    std::vector<StudyPoint> samples = optimise_samples(plan_);
    plan_.inputs = complete_inputs({plan_.inputs, plan_.calibration}, head_.twin);
    return samples;
  }
  PointTask task() const override { return {head_.twin, head_.records, true, plan_.inputs.calibration > 0}; }

  void run(KeptPoints& kept) override {
    say(fmt::format("study \"{}\": at most {} evaluations of {} trials", head_.name, plan_.evaluations,
                    plan_.trials));
    result_ = run_optimise(plan_, [&](const std::vector<StudyPoint>& batch) {
      say(fmt::format("evaluation {} of at most {}", evaluations_text(batch, plan_.trials),
                      plan_.evaluations));
      return kept.run(batch);
    });
  }

  std::string write() const override { return optimise_json(plan_, result_); }
  StudyReport report(const StudyRecord& study) const override {
    return optimise_report(study, plan_, result_);
  }

  std::string tell(const StudyRecord&, const EngineSummary& summary) const override {
    std::string out = fmt::format("study \"{}\": {} evaluations, {} in this run\n", head_.name,
                                  result_.evaluations.size(), points_text(summary.finished));
    if (result_.best) out += evaluation_line("best", result_.evaluations[*result_.best]);
    for (const std::size_t i : result_.front)
      if (i != result_.best) out += evaluation_line("quicker", result_.evaluations[i]);
    return out;
  }
  ExitCode verdict() const override {
    if (result_.best) return ExitCode::ok;
    warn("nothing that was tried meets all constraints: see result.json");
    return ExitCode::no_convergence;
  }

 private:
  const StudyHead& head_;
  OptimisePlan plan_;
  OptimiseResult result_;
};

}  // namespace

std::unique_ptr<Kind> make_kind(const StudyHead& head, const OptimisePlan& plan) {
  return std::make_unique<OptimiseKind>(head, plan);
}

}  // namespace fringetwin::study
