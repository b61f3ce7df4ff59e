// SPDX-License-Identifier: Apache-2.0
#include "report/json.hpp"
#include "study/optimise/optimise.hpp"

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

Json json(const OptimisePlan& plan, const Evaluation& e) {
  Json out = {{"phase", e.phase},
              {"values", e.values},
              {"objective", json_number(e.objective.value)},
              {"objective_sigma", json_number(e.objective.sigma)},
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

const char* name_of(Statistic statistic) {
  if (statistic == Statistic::mean) return "mean";
  return statistic == Statistic::sigma ? "sigma" : "rms-error";
}

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
              {"evaluations", Json::array()}};
  if (plan.statistic == Statistic::rms_error) out["minimise"]["value"] = plan.value;
  for (const Constraint& c : plan.constraints)
    out["constraints"].push_back({{"result", c.result}, {"min", json(c.min)}, {"max", json(c.max)}});
  for (const Variation& v : plan.choose) out["choose"].push_back(json(v));
  for (const Evaluation& e : result.evaluations) out["evaluations"].push_back(json(plan, e));
  return out.dump(1) + "\n";
}

}  // namespace fringetwin::study
