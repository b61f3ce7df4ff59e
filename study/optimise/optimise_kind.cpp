// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "optimise": searches for the settings of the rig with which a number is least
// uncertain.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "report/json.hpp"
#include "study/optimise/optimise.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

using report::Json, report::json_number;

Json json(const std::optional<double>& limit) { return limit ? Json(*limit) : Json(nullptr); }

Json json(const Variation& v) {
  Json out = {{"keys", v.keys}};
  if (v.range) {
    out["range"] = {v.range->first, v.range->last};
    out["scale"] = v.range->log ? "log" : "linear";
  } else if (!v.rows.empty()) {
    out["rows"] = v.rows;
  } else {
    out["values"] = v.values;
  }
  return out;
}

/// Returns what trials say of a setting.
Json json(const OptimisePlan& plan, const Evaluation& e) {
  Json out = {{"objective", json_number(e.objective.value)},
              {"objective_sigma", json_number(e.objective.sigma)},
              {"objective_interval",
               report::json_numbers(std::array{e.objective.interval.low, e.objective.interval.high})},
              {"constraints", Json::array()},
              {"time_s", json_number(e.time_s)},
              {"feasible", e.feasible},
              {"failed", e.failed}};
  for (std::size_t k = 0; k < plan.constraints.size(); ++k)
    out["constraints"].push_back({{"result", plan.constraints[k].result},
                                  {"mean", json_number(e.constraints[k].value)},
                                  {"mean_sigma", json_number(e.constraints[k].sigma)}});
  if (!e.reason.empty()) out["reason"] = e.reason;
  return out;
}

/// Returns an evaluation of the search.
Json searched(const OptimisePlan& plan, const Evaluation& e) {
  Json out = {{"phase", e.phase}, {"values", e.values}, {"theory", json_number(e.theory)}};
  out.update(json(plan, e));
  return out;
}

/// Returns the one that was chosen, and those that its trials do not tell from it.
Json json_of_chosen(const OptimisePlan& plan, const OptimiseResult& result) {
  if (!result.chosen) return nullptr;
  Json out = json(plan, *result.chosen);
  out["evaluation"] = *result.best;
  out["not_told_apart"] = result.not_told_apart();
  out["recommended"] = *result.recommended;
  return out;
}

const char* name_of(Statistic statistic) {
  if (statistic == Statistic::mean) return "mean";
  return statistic == Statistic::sigma ? "sigma" : "rms-error";
}

/// Returns the numbers of the evaluations in a batch, "7" or "1 ... 30".
std::string evaluations_text(const std::vector<StudyPoint>& batch, std::size_t trials) {
  const auto first = static_cast<std::size_t>(batch.front().id) / trials + 1, n = batch.size() / trials;
  return n == 1 ? fmt::format("{}", first) : fmt::format("{} ... {}", first, first + n - 1);
}

/// Returns "best 0.0021 (0.0017 ... 0.0027), 0.36 s: projector.intensity = 40"
std::string evaluation_line(const char* what, const Evaluation& e) {
  std::vector<std::string> values;
  for (const auto& [key, text] : e.values) values.push_back(key + " = " + text);
  return fmt::format("{} {:.3g} ({:.3g} ... {:.3g}){}: {}\n", what, e.objective.value,
                     e.objective.interval.low, e.objective.interval.high,
                     std::isnan(e.time_s) ? "" : fmt::format(", {:g} s", e.time_s), fmt::join(values, ", "));
}

class OptimiseKind final : public Kind {
 public:
  OptimiseKind(const StudyHead& head, const OptimisePlan& plan) : head_(head), plan_(plan) {}

  PointSequence plan() override {
    std::vector<StudyPoint> samples = optimise_samples(plan_);
    plan_.inputs = complete_inputs(plan_, head_.twin);
    return samples;
  }
  PointTask task() const override { return {head_.twin, head_.records, true, plan_.inputs.calibration > 0}; }

  void run(KeptPoints& kept) override {
    say(fmt::format("study \"{}\": at most {} evaluations of {} trials", head_.name, plan_.evaluations,
                    plan_.trials));
    const auto measure = [&](const std::vector<StudyPoint>& batch) {
      say(static_cast<std::size_t>(batch.front().id) < plan_.evaluations * plan_.trials
              ? fmt::format("evaluation {} of at most {}", evaluations_text(batch, plan_.trials),
                            plan_.evaluations)
              : fmt::format("the best again, with {} fresh draws each", kFreshTrials * plan_.trials));
      return kept.run(batch);
    };
    result_ = run_optimise(plan_, measure, foreknowledge(plan_));
  }

  std::string write() const override { return optimise_json(plan_, result_); }
  StudyReport report(const StudyRecord& study) const override {
    return optimise_report(study, plan_, result_);
  }

  std::string tell(const StudyRecord&, const EngineSummary& summary) const override {
    std::string out = fmt::format("study \"{}\": {} evaluations, {} in this run\n", head_.name,
                                  result_.evaluations.size(), points_text(summary.finished));
    if (result_.screened > 0)
      out += fmt::format("{} settings put in order by their closed form, without measurements\n",
                         result_.screened);
    if (result_.left_out > 0)
      out += fmt::format("{} settings left out that are no valid twin: {}\n", result_.left_out,
                         result_.left_out_reason);
    if (!result_.best) return out;
    out += evaluation_line("best", *result_.chosen);
    for (const std::size_t i : result_.not_told_apart())
      out +=
          evaluation_line(i == result_.recommended ? "not told apart from the best, and quicker: recommended"
                                                   : "not told apart from the best",
                          result_.last_of(i));
    for (const std::size_t i : result_.front)
      if (result_.last_of(i).time_s < result_.chosen->time_s)
        out += evaluation_line("quicker", result_.last_of(i));
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

std::string optimise_json(const OptimisePlan& plan, const OptimiseResult& result) {
  Json out = {{"schema", "fringetwin-optimise/1"},
              {"minimise", {{"result", plan.result}, {"statistic", name_of(plan.statistic)}}},
              {"constraints", Json::array()},
              {"choose", Json::array()},
              {"factors", plan.inputs.factors()},
              {"trials", plan.trials},
              {"budget", plan.evaluations},
              {"seed", plan.seed},
              {"best", result.best ? Json(*result.best) : Json(nullptr)},
              {"front", result.front},
              {"fresh_trials", kFreshTrials * plan.trials},
              {"screened", result.screened},
              {"left_out", result.left_out},
              {"chosen", json_of_chosen(plan, result)},
              {"candidates", Json::array()},
              {"evaluations", Json::array()}};
  if (plan.statistic == Statistic::rms_error) out["minimise"]["value"] = plan.value;
  for (const Constraint& c : plan.constraints)
    out["constraints"].push_back({{"result", c.result}, {"min", json(c.min)}, {"max", json(c.max)}});
  for (const Variation& v : plan.choose) out["choose"].push_back(json(v));
  if (result.left_out > 0) out["left_out_reason"] = result.left_out_reason;
  for (const Candidate& c : result.candidates) {
    out["candidates"].push_back(json(plan, c.fresh));
    out["candidates"].back()["evaluation"] = c.evaluation;
    out["candidates"].back()["told_apart"] = c.told_apart;
  }
  for (const Evaluation& e : result.evaluations) out["evaluations"].push_back(searched(plan, e));
  return out.dump(1) + "\n";
}

std::unique_ptr<Kind> make_kind(const StudyHead& head, const OptimisePlan& plan) {
  return std::make_unique<OptimiseKind>(head, plan);
}

}  // namespace fringetwin::study
