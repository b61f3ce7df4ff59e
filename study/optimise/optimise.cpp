// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/optimise.hpp"

#include <algorithm>
#include <cmath>

#include "study/optimise/budgeted_search.hpp"
#include "study/optimise/trials.hpp"
#include "study/plan/space_filling.hpp"
#include "study/plan/study_tables.hpp"

namespace fringetwin::study {
namespace {

constexpr std::size_t kMostScreened = 400;  // settings whose objective is worked out in closed form

Settings chosen(const OptimisePlan& plan, const Place& place) {
  Settings out;
  for (std::size_t d = 0; d < place.size(); ++d) assign_at(plan.choose[d], place[d], &out);
  return out;
}

SearchPlan search_plan(const OptimisePlan& plan) {
  SearchPlan out;
  for (const Variation& v : plan.choose) out.values.push_back(v.range ? 0 : v.values.size());
  for (const Constraint& c : plan.constraints)
    out.constraints += (c.min ? std::size_t{1} : 0) + (c.max ? std::size_t{1} : 0);
  out.evaluations = plan.evaluations;
  out.seed = plan.seed;
  return out;
}

/// What the closed form says where it is not known for all settings: nothing.
struct NotInTheory {};

class Optimisation {
 public:
  Optimisation(const OptimisePlan& plan, const RunPoints& run, const Foreknowledge& known)
      : plan_(plan), run_(run), known_(known), search_plan_(search_plan(plan)) {
    if (known_.fault) search_plan_.allowed = [this](const Place& place) { return is_valid(place); };
  }

  OptimiseResult result() {
    search_plan_.first = screen();
    const SearchResult found = search(search_plan_, [&](const std::vector<Place>& places, std::size_t first) {
      return measure(places, first);
    });
    for (std::size_t i = 0; i < out_.evaluations.size(); ++i)
      out_.evaluations[i].phase = found.tried[i].phase;
    confirm(spread_best(search_plan_, found.tried));
    recommend();
    set_front();
    return std::move(out_);
  }

 private:
  bool is_valid(const Place& place) {
    const auto [at, fresh] = valid_.try_emplace(place, true);
    if (!fresh) return at->second;
    const std::string fault = known_.fault(chosen(plan_, place));
    if (fault.empty()) return true;
    if (out_.left_out++ == 0) out_.left_out_reason = fault;
    return at->second = false;
  }

  /// Returns places of the box by their objective in closed form; none where it is not known for all.
  std::vector<Place> screen() {
    const bool any_range =
        std::ranges::any_of(plan_.choose, [](const Variation& v) { return v.range.has_value(); });
    // The closed form knows no constraint: along a range their limit must be found by measuring.
    if (!known_.theory || (any_range && !plan_.constraints.empty())) return {};
    SearchPlan box = search_plan_;
    box.constraints = 0;
    box.evaluations = kMostScreened;
    SearchResult found;
    try {
      found = search(box, [&](const std::vector<Place>& places, std::size_t) {
        std::vector<Assessment> out;
        for (const Place& place : places) {
          const auto value = known_.theory(chosen(plan_, place));
          if (!value) throw NotInTheory();
          theory_[place] = *value;
          out.push_back({*value, {}});
        }
        return out;
      });
    } catch (const NotInTheory&) {
      theory_.clear();
      return {};
    }
    out_.screened = found.tried.size();
    std::vector<Place> places;
    for (const std::size_t i : spread_best(search_plan_, found.tried)) places.push_back(found.tried[i].place);
    return places;
  }

  std::vector<Assessment> measure(const std::vector<Place>& places, std::size_t first) {
    std::vector<Settings> values;
    for (const Place& place : places) values.push_back(chosen(plan_, place));
    const std::vector<Evaluation> found =
        evaluate(plan_, run_, values, {static_cast<std::int64_t>(first * plan_.trials), 0, plan_.trials});
    std::vector<Assessment> answers;
    for (std::size_t i = 0; i < places.size(); ++i) {
      out_.evaluations.push_back(found[i]);
      if (const auto theory = theory_.find(places[i]); theory != theory_.end())
        out_.evaluations.back().theory = theory->second;
      answers.push_back(assessment_of(plan_, found[i]));
    }
    return answers;
  }

  /// Measures the best five again, the next five where none of them is feasible, and the best of these once
  /// more, or the next one where that third set is not feasible: the least of several noisy values is too
  /// small, that of a third set is not.
  void confirm(const std::vector<std::size_t>& order) {
    const std::size_t fresh = kFreshTrials * plan_.trials;
    const auto id = [&] {
      return static_cast<std::int64_t>(plan_.evaluations * plan_.trials + out_.candidates.size() * fresh);
    };
    const std::size_t most = std::min(order.size(), kMostRounds * kMostCandidates);
    std::vector<std::size_t> feasible;  // places among the candidates
    for (std::size_t first = 0; first < most && feasible.empty(); first += kMostCandidates) {
      const std::size_t end = std::min(first + kMostCandidates, most);
      std::vector<Settings> values;
      for (std::size_t i = first; i < end; ++i) values.push_back(out_.evaluations[order[i]].values);
      const std::vector<Evaluation> again = evaluate(plan_, run_, values, {id(), plan_.trials, fresh});
      for (std::size_t i = first; i < end; ++i) out_.candidates.push_back({order[i], again[i - first]});
      for (std::size_t c = first; c < end; ++c)
        if (out_.candidates[c].fresh.feasible) feasible.push_back(c);
    }
    std::ranges::stable_sort(feasible, {},
                             [&](std::size_t c) { return out_.candidates[c].fresh.objective.value; });
    for (std::size_t k = 0; k < feasible.size() && !out_.chosen; ++k) {
      const Candidate& c = out_.candidates[feasible[k]];
      const TrialBlock third{id() + static_cast<std::int64_t>(k * fresh), plan_.trials + fresh, fresh};
      if (Evaluation again = evaluate(plan_, run_, {c.fresh.values}, third).front(); again.feasible) {
        out_.best = c.evaluation;
        out_.chosen = std::move(again);
      }
    }
  }

  /// The third set of the best one is independent of the second sets, so Fisher's F holds as it stands.
  void recommend() {
    if (!out_.chosen) return;
    for (Candidate& c : out_.candidates)
      c.told_apart = c.evaluation != *out_.best &&
                     is_surely_less(out_.chosen->objective, c.fresh.objective, plan_.statistic);
    out_.recommended = out_.best;
    for (const std::size_t i : out_.not_told_apart())
      if (out_.last_of(i).time_s < out_.last_of(*out_.recommended).time_s) out_.recommended = i;
  }

  void set_front() {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < out_.evaluations.size(); ++i)
      if (out_.is_feasible(i) && !std::isnan(out_.last_of(i).time_s)) order.push_back(i);
    std::ranges::stable_sort(order, {}, [&](std::size_t i) {
      const Evaluation& e = out_.last_of(i);
      return std::pair{e.time_s, e.objective.value};
    });
    for (const std::size_t i : order)
      if (out_.front.empty() || is_surely_less(out_.last_of(i).objective,
                                               out_.last_of(out_.front.back()).objective, plan_.statistic))
        out_.front.push_back(i);
  }

  const OptimisePlan& plan_;
  const RunPoints& run_;
  const Foreknowledge& known_;
  SearchPlan search_plan_;
  std::map<Place, bool> valid_;
  std::map<Place, double> theory_;
  OptimiseResult out_;
};

}  // namespace

std::vector<Record> optimise_records(const OptimisePlan& plan) {
  std::vector<std::string> names = needed_results(plan);
  names.emplace_back(kTimeResult);
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::vector<Record> out;
  for (const std::string& name : names) out.push_back({name, name});
  return out;
}

std::vector<StudyPoint> optimise_samples(const OptimisePlan& plan) {
  const UncertainInputs& inputs = plan.inputs;
  std::vector<StudyPoint> out(1);
  out.push_back(point_of(inputs, 1, draw_inputs(inputs, plan.seed, DrawStream::trials, 0)));
  for (const Variation& v : plan.choose) {
    const std::size_t n = v.range ? 2 : v.values.size();
    for (std::size_t i = 0; i < n; ++i) {
      out.push_back({static_cast<std::int64_t>(out.size()), {}, 0});
      assign_at(v, v.range ? static_cast<double>(i) : middle_of_share(i, n), &out.back().settings);
    }
  }
  return out;
}

OptimiseResult run_optimise(const OptimisePlan& plan, const RunPoints& run, const Foreknowledge& known) {
  return Optimisation(plan, run, known).result();
}

const Evaluation& OptimiseResult::last_of(std::size_t evaluation) const {
  if (chosen && best == evaluation) return *chosen;
  const auto again = std::ranges::find(candidates, evaluation, &Candidate::evaluation);
  return again == candidates.end() ? evaluations[evaluation] : again->fresh;
}

bool OptimiseResult::is_feasible(std::size_t evaluation) const {
  const auto again = std::ranges::find(candidates, evaluation, &Candidate::evaluation);
  return evaluations[evaluation].feasible && (again == candidates.end() || again->fresh.feasible);
}

std::vector<std::size_t> OptimiseResult::not_told_apart() const {
  std::vector<std::size_t> out;
  for (const Candidate& c : candidates)
    if (best && c.evaluation != *best && c.fresh.feasible && !c.told_apart) out.push_back(c.evaluation);
  return out;
}

}  // namespace fringetwin::study
