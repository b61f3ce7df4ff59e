// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "render/base/sobol.hpp"
#include "study/optimise/optimise.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

constexpr int kMostEvaluations = 100'000, kMostTrials = 10'000;

Variation read_choice(const TomlTable& table, std::set<std::string>* taken) {
  Variation out = read_variation(table, true, taken);
  const char* name = table.has("key") ? "key" : "keys";
  // A key of one and the same camera must have one name, or what is chosen and what is uncertain would not
  // meet.
  for (const std::string& key : out.keys)
    for (const char* list : {"camera[", "object[", "measure.fit["})
      if (key.starts_with(list))
        table.fail(name, fmt::format("\"{}\" goes by number", key), "give the name, as in camera.left");
  return out;
}

void read_objective(const TomlTable& root, OptimisePlan* plan) {
  const auto table = root.table("minimise");
  if (!table) root.fail("minimise", "is missing", "say what is to be least: [minimise] result = ...");
  table->allow({"result", "statistic", "value"});
  plan->result = table->required_string("result");
  const std::string statistic = table->choice("statistic", {"sigma", "mean", "rms-error"}).value_or("sigma");
  plan->statistic = statistic == "mean"    ? Statistic::mean
                    : statistic == "sigma" ? Statistic::sigma
                                           : Statistic::rms_error;
  if (plan->statistic == Statistic::rms_error)
    plan->value = table->required_number("value", NumberRange::any_size());
  else if (table->has("value"))
    table->fail("value", fmt::format("has no effect with statistic = \"{}\"", statistic));
}

Constraint read_constraint(const TomlTable& table) {
  table.allow({"result", "min", "max"});
  Constraint out{table.required_string("result"), table.number("min", NumberRange::any_size()),
                 table.number("max", NumberRange::any_size())};
  if (!out.min && !out.max) table.fail("", "needs min, max or both");
  if (out.min && out.max && *out.min > *out.max) table.fail("max", "is below min");
  return out;
}

}  // namespace

std::vector<std::string> optimise_keys() {
  return with_uncertain_keys({"choose", "minimise", "constraint", "evaluations", "trials"});
}

OptimisePlan read_optimise(const TomlTable& root, const std::filesystem::path& twin_file) {
  OptimisePlan plan;
  plan.twin = twin_file;
  std::set<std::string> taken;
  for (const TomlTable& table : root.tables("choose")) plan.choose.push_back(read_choice(table, &taken));
  if (plan.choose.empty()) root.fail("choose", "is missing", "say what may be chosen: [[choose]] key = ...");
  if (plan.choose.size() > std::size_t{render::kSobolDimensions})
    root.fail("choose", fmt::format("is given {} times, at most {} are possible", plan.choose.size(),
                                    render::kSobolDimensions));
  read_objective(root, &plan);
  for (const TomlTable& table : root.tables("constraint")) plan.constraints.push_back(read_constraint(table));
  plan.evaluations = root.integer("evaluations", 1, kMostEvaluations).value_or(60);
  plan.trials = root.integer("trials", 2, kMostTrials).value_or(8);
  // the search's, those of the best again, and of these once more until one is feasible
  const std::size_t most = plan.evaluations + kFreshTrials * (kMostRounds + 1) * kMostCandidates;
  if (most * plan.trials > std::size_t{kMostPoints})
    root.fail("evaluations", fmt::format("x trials must not exceed {}", kMostPoints));
  plan.seed = root.integer("seed", 0, kMostSeed).value_or(1);
  static_cast<UncertainSettings&>(plan) = read_uncertain_settings(root, twin_file);
  for (const UncertainKey& key : plan.inputs.keys)
    if (key.stated && std::ranges::any_of(key.keys, [&](const std::string& k) { return taken.contains(k); }))
      root.fail("uncertain", fmt::format("\"{}\" is chosen, too: its middle is what is chosen", key.name),
                "leave out value");
  return plan;
}

}  // namespace fringetwin::study
