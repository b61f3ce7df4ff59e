// SPDX-License-Identifier: Apache-2.0
#include "study/monte_carlo/monte_carlo_study.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "report/json.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

using report::Json, report::json_number;

/// The numbers of the points that did not fail, found by id.
class Outcomes {
 public:
  void add(const std::vector<PointOutcome>& outcomes) {
    for (const PointOutcome& o : outcomes) {
      if (o.failed) continue;
      by_id_[o.id] = o.numbers;
      for (const auto& [name, value] : o.numbers) names_.insert(name);
    }
  }
  const std::set<std::string>& names() const { return names_; }
  bool has(std::int64_t id) const { return by_id_.contains(id); }
  double value(std::int64_t id, const std::string& name) const {
    const auto point = by_id_.find(id);
    if (point == by_id_.end()) return std::nan("");
    const auto number = point->second.find(name);
    return number == point->second.end() ? std::nan("") : number->second;
  }
  std::vector<double> trials(const std::string& name, std::size_t n) const {
    std::vector<double> out(n);
    for (std::size_t i = 0; i < n; ++i) out[i] = value(static_cast<std::int64_t>(i), name);
    return out;
  }

 private:
  std::map<std::int64_t, std::map<std::string, double>> by_id_;
  std::set<std::string> names_;
};

InputDraw trial_draw(const MonteCarloPlan& plan, std::size_t trial) {
  return draw_inputs(plan.inputs, plan.seed, DrawStream::trials, trial);
}

/// Returns the id of a point of a row of the sensitivity: part 0 is the second sample, factors count from 1.
std::int64_t row_id(const MonteCarloPlan& plan, std::size_t row, std::size_t part) {
  return kFirstRowId + static_cast<std::int64_t>(row * (1 + plan.inputs.factors().size()) + part);
}

std::vector<StudyPoint> row_points(const MonteCarloPlan& plan) {
  std::vector<StudyPoint> out;
  for (std::size_t row = 0; row < plan.sensitivity_rows; ++row) {
    const InputDraw a = trial_draw(plan, row),
                    b = draw_inputs(plan.inputs, plan.seed, DrawStream::sensitivity_b, row);
    out.push_back(point_of(plan.inputs, row_id(plan, row, 0), b));
    for (std::size_t f = 0; f < plan.inputs.factors().size(); ++f)
      out.push_back(point_of(plan.inputs, row_id(plan, row, f + 1), exchanged(plan.inputs, a, b, f)));
  }
  return out;
}

SobolIndices indices(const MonteCarloPlan& plan, const Outcomes& outcomes, const std::string& name) {
  SobolSample sample;
  sample.a = outcomes.trials(name, plan.sensitivity_rows);
  sample.a_with_b.resize(plan.inputs.factors().size());
  for (std::size_t row = 0; row < plan.sensitivity_rows; ++row) {
    sample.b.push_back(outcomes.value(row_id(plan, row, 0), name));
    for (std::size_t f = 0; f < sample.a_with_b.size(); ++f)
      sample.a_with_b[f].push_back(outcomes.value(row_id(plan, row, f + 1), name));
  }
  return sobol_indices(sample, plan.rule.coverage, plan.seed);
}

/// Fills in how far each number is known after `out.trials` trials.
void judge(const MonteCarloPlan& plan, const Outcomes& outcomes, MonteCarloResult& out) {
  out.converged = !outcomes.names().empty();
  for (const std::string& name : outcomes.names()) {
    MonteCarloNumber& n = out.numbers[name];
    n.convergence = convergence(outcomes.trials(name, out.trials), plan.rule);
    out.converged = out.converged && n.convergence.reached;
  }
}

Json interval(const Interval& i) { return report::json_numbers(std::array{i.low, i.high}); }

}  // namespace

MonteCarloResult run_monte_carlo(const MonteCarloPlan& plan, const RunPoints& run,
                                 const std::function<void(const MonteCarloResult&)>& after_block) {
  FT_CHECK(plan.sensitivity_rows <= plan.most_trials, "rows of the sensitivity are trials");
  Outcomes outcomes;
  MonteCarloResult out;
  out.factors = plan.inputs.factors();
  while (out.trials < plan.most_trials && (!out.converged || out.trials < plan.sensitivity_rows)) {
    const std::size_t end = std::min(out.trials + plan.rule.trials_per_block(), plan.most_trials);
    std::vector<StudyPoint> points;
    for (std::size_t i = out.trials; i < end; ++i)
      points.push_back(point_of(plan.inputs, static_cast<std::int64_t>(i), trial_draw(plan, i)));
    outcomes.add(run(points));
    out.trials = end;
    judge(plan, outcomes, out);
    if (after_block) after_block(out);
  }
  if (plan.sensitivity_rows > 0) outcomes.add(run(row_points(plan)));
  for (std::size_t i = 0; i < out.trials; ++i) out.failed += !outcomes.has(static_cast<std::int64_t>(i));
  for (auto& [name, n] : out.numbers) {
    n.summary = summarise(outcomes.trials(name, out.trials), plan.rule.coverage);
    if (plan.sensitivity_rows > 0) n.sensitivity = indices(plan, outcomes, name);
  }
  return out;
}

MonteCarloResult monte_carlo_so_far(const MonteCarloPlan& plan, const std::vector<StoredPoint>& rows) {
  Outcomes outcomes;
  MonteCarloResult out;
  out.factors = plan.inputs.factors();
  std::size_t end = 0;  // behind the last trial that has finished
  for (const StoredPoint& row : rows) {
    if (row.status == PointStatus::pending || row.point.id >= kFirstRowId) continue;
    const auto id = static_cast<std::size_t>(row.point.id);
    outcomes.add({row.outcome});
    end = std::max(end, id + 1);
    ++out.trials;
    out.failed += row.outcome.failed ? 1 : 0;
  }
  const std::size_t finished = std::exchange(out.trials, end);  // those between are numbers that are missing
  judge(plan, outcomes, out);
  out.trials = finished;
  for (auto& [name, n] : out.numbers) n.summary = summarise(outcomes.trials(name, end), plan.rule.coverage);
  return out;
}

std::optional<std::size_t> trials_foreseen(const MonteCarloResult& result) {
  std::size_t most = 0;
  for (const auto& [name, n] : result.numbers) {
    const std::optional<std::size_t> needed = trials_foreseen(n.convergence, result.trials);
    if (!needed) return std::nullopt;
    most = std::max(most, *needed);
  }
  return most > 0 ? std::optional(most) : std::nullopt;
}

std::string monte_carlo_json(const MonteCarloPlan& plan, const MonteCarloResult& result) {
  Json out = {{"schema", "fringetwin-monte-carlo/1"},
              {"coverage", plan.rule.coverage},
              {"digits", plan.rule.digits},
              {"block_trials", plan.rule.trials_per_block()},
              {"seed", plan.seed},
              {"trials", result.trials},
              {"failed", result.failed},
              {"converged", result.converged},
              {"numbers", Json::array()}};
  for (const auto& [name, n] : result.numbers) {
    Json row = {{"name", name},
                {"n", n.summary.n},
                {"mean", json_number(n.summary.mean)},
                {"sigma", json_number(n.summary.sigma)},
                {"symmetric", interval(n.summary.symmetric)},
                {"shortest", interval(n.summary.shortest)},
                {"converged", n.convergence.reached},
                {"tolerance", json_number(n.convergence.tolerance)},
                {"twice_error",
                 {{"mean", json_number(n.convergence.mean)},
                  {"sigma", json_number(n.convergence.sigma)},
                  {"low", json_number(n.convergence.low)},
                  {"high", json_number(n.convergence.high)}}}};
    if (!n.sensitivity.first.empty()) {
      row["sensitivity_rows"] = n.sensitivity.rows;
      row["sensitivity"] = Json::array();
      std::vector<std::size_t> order(result.factors.size());
      for (std::size_t f = 0; f < order.size(); ++f) order[f] = f;
      std::ranges::stable_sort(order, [&total = n.sensitivity.total](std::size_t a, std::size_t b) {
        return total[a].value > total[b].value;
      });
      for (const std::size_t f : order)
        row["sensitivity"].push_back({{"factor", result.factors[f]},
                                      {"first", json_number(n.sensitivity.first[f].value)},
                                      {"first_interval", interval(n.sensitivity.first[f].interval)},
                                      {"total", json_number(n.sensitivity.total[f].value)},
                                      {"total_interval", interval(n.sensitivity.total[f].interval)}});
    }
    out["numbers"].push_back(std::move(row));
  }
  return out.dump(2) + "\n";
}

}  // namespace fringetwin::study
