// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/budgeted_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "study/optimise/local_search.hpp"
#include "study/plan/space_filling.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

constexpr double kLeastStep = 1e-3;    // of the box
constexpr double kSamePlace = 0.02;    // of the box: what lies nearer is no other setting
constexpr double kMostListed = 4096;   // combinations of lists that are looked at one by one
constexpr std::size_t kMostDraws = 8;  // of Sobol's points for each that is wanted, where values repeat

class Search {
 public:
  Search(const SearchPlan& plan, const Assess& assess) : plan_(plan), assess_(assess) {
    for (std::size_t d = 0; d < plan.values.size(); ++d)
      if (plan.values[d] == 0) continuous_.push_back(d);
  }

  SearchResult run() {
    if (!first_are_enough()) everywhere();
    out_.best = best();
    if (out_.best && !out_.tried[*out_.best].assessment.feasible()) out_.best.reset();
    return std::move(out_);
  }

 private:
  std::size_t left() const { return plan_.evaluations - out_.tried.size(); }

  bool is_allowed(const Place& place) const { return !plan_.allowed || plan_.allowed(place); }

  bool first_are_enough() {
    std::size_t feasible = 0, next = 0;
    while (feasible < plan_.enough && next < plan_.first.size() && 2 * left() > plan_.evaluations) {
      const std::size_t end = std::min(next + plan_.enough - feasible, plan_.first.size());
      const std::size_t before = out_.tried.size();
      evaluate({plan_.first.begin() + static_cast<std::ptrdiff_t>(next),
                plan_.first.begin() + static_cast<std::ptrdiff_t>(end)},
               "screened");
      for (std::size_t i = before; i < out_.tried.size(); ++i)
        feasible += out_.tried[i].assessment.feasible() ? 1 : 0;
      next = end;
    }
    return feasible >= plan_.enough;
  }

  void everywhere() {
    global();
    while (left() > 0) {
      const std::optional<std::size_t> before = best();
      if (!continuous_.empty()) local();
      if (continuous_.size() < plan_.values.size()) steps();
      if (best() == before) break;
    }
  }

  /// Assesses those places that are allowed and were not tried yet, while the budget lasts.
  void evaluate(std::vector<Place> places, const char* phase) {
    std::vector<Place> fresh;
    for (Place& place : places)
      if (fresh.size() < left() && is_allowed(place) &&
          known_.try_emplace(place, out_.tried.size() + fresh.size()).second)
        fresh.push_back(std::move(place));
    if (fresh.empty()) return;
    const std::vector<Assessment> answers = assess_(fresh, out_.tried.size());
    FT_CHECK(answers.size() == fresh.size(), "an answer for each place");
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      FT_CHECK(answers[i].excess.size() == plan_.constraints, "every constraint");
      out_.tried.push_back({std::move(fresh[i]), phase, answers[i]});
    }
  }

  /// Tries places over the whole box with half of the budget; all combinations of lists where the budget
  /// lasts.
  void global() {
    double combinations = continuous_.empty() ? 1.0 : HUGE_VAL;
    for (const std::size_t n : plan_.values) combinations *= n == 0 ? 1.0 : static_cast<double>(n);
    if (combinations <= std::max(kMostListed, static_cast<double>(plan_.evaluations))) {
      std::vector<Place> all = every_combination();
      std::erase_if(all, [&](const Place& place) { return !is_allowed(place); });
      if (all.size() <= plan_.evaluations) return evaluate(std::move(all), "global");
    }
    const std::size_t wanted = (plan_.evaluations + 1) / 2;
    std::vector<Place> places;
    std::set<Place> seen;
    for (Place place : scrambled_sobol(static_cast<int>(kMostDraws * wanted),
                                       static_cast<int>(plan_.values.size()), plan_.seed)) {
      if (places.size() == wanted) break;
      for (std::size_t d = 0; d < place.size(); ++d)
        if (const std::size_t n = plan_.values[d]; n > 0)
          place[d] = middle_of_share(share_of(place[d], n), n);
      if (seen.insert(place).second && is_allowed(place)) places.push_back(std::move(place));
    }
    step_ = std::min(0.25, 0.5 * std::pow(static_cast<double>(places.size()),
                                          -1.0 / static_cast<double>(plan_.values.size())));
    evaluate(std::move(places), "global");
  }

  std::vector<Place> every_combination() const {
    std::vector<Place> out = {{}};
    for (const std::size_t n : plan_.values) {
      std::vector<Place> longer;
      for (const Place& place : out)
        for (std::size_t i = 0; i < n; ++i) {
          longer.push_back(place);
          longer.back().push_back(middle_of_share(i, n));
        }
      out = std::move(longer);
    }
    return out;
  }

  /// Searches the continuous dimensions from the best place, with its listed values.
  void local() {
    const auto from = best();
    if (!from) return;
    const Place base = out_.tried[*from].place;
    const Scale scale = current_scale();
    std::vector<double> start;
    for (const std::size_t d : continuous_) start.push_back(base[d]);
    local_search(
        [&](const std::vector<double>& x) {
          Place place = base;
          for (std::size_t i = 0; i < x.size(); ++i) place[continuous_[i]] = std::clamp(x[i], 0.0, 1.0);
          if (!is_allowed(place)) return scale.of({});
          if (!known_.contains(place)) {
            if (left() == 0) throw EnoughOfIt();
            evaluate({place}, "local");
          }
          return scale.of(out_.tried[known_.at(place)].assessment);
        },
        std::move(start), plan_.constraints, step_, kLeastStep);
    step_ = std::max(0.25 * step_, 4.0 * kLeastStep);  // of a next one
  }

  /// Tries the neighbours of the best place: one value up or down in each list.
  void steps() {
    const auto from = best();
    if (!from || left() == 0) return;
    std::vector<Place> places;
    for (std::size_t d = 0; d < plan_.values.size(); ++d) {
      const std::size_t n = plan_.values[d];
      if (n == 0) continue;
      const std::size_t i = share_of(out_.tried[*from].place[d], n);
      for (const bool up : {false, true}) {
        if (up ? i + 1 == n : i == 0) continue;
        places.push_back(out_.tried[*from].place);
        places.back()[d] = middle_of_share(up ? i + 1 : i - 1, n);
      }
    }
    evaluate(std::move(places), "steps");
  }

  /// Makes objective and constraints numbers of order 1, what failed as bad as the worst.
  struct Scale {
    double zero = 0.0, objective = 1.0, worst = 1.0;
    std::vector<double> excess;

    LocalValue of(const Assessment& a) const {
      if (a.failed()) return {worst, std::vector<double>(excess.size(), 1.0)};
      LocalValue out{(a.objective - zero) / objective, a.excess};
      for (std::size_t k = 0; k < excess.size(); ++k) out.excess[k] /= excess[k];
      return out;
    }
  };
  Scale current_scale() const {
    Scale s;
    s.excess.assign(plan_.constraints, 0.0);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Tried& t : out_.tried) {
      if (t.assessment.failed()) continue;
      low = std::min(low, t.assessment.objective);
      high = std::max(high, t.assessment.objective);
      for (std::size_t k = 0; k < s.excess.size(); ++k)
        s.excess[k] = std::max(s.excess[k], std::abs(t.assessment.excess[k]));
    }
    if (low <= high) s.zero = low;
    if (high > low) s.objective = high - low;
    for (double& e : s.excess)
      if (!(e > 0.0)) e = 1.0;
    return s;
  }

  /// Returns the best place so far: the feasible one with the least objective, else the one that exceeds the
  /// constraints least; nothing where all have failed.
  std::optional<std::size_t> best() const {
    const Scale scale = current_scale();
    std::optional<std::size_t> best;
    double best_excess = HUGE_VAL, best_objective = HUGE_VAL;
    for (std::size_t i = 0; i < out_.tried.size(); ++i) {
      const Assessment& a = out_.tried[i].assessment;
      if (a.failed()) continue;
      double excess = 0.0;
      for (std::size_t k = 0; k < a.excess.size(); ++k)
        excess += std::max(a.excess[k], 0.0) / scale.excess[k];
      if (excess > best_excess || (excess == best_excess && a.objective >= best_objective)) continue;
      best = i;
      best_excess = excess;
      best_objective = a.objective;
    }
    return best;
  }

  const SearchPlan& plan_;
  const Assess& assess_;
  std::vector<std::size_t> continuous_;
  double step_ = 0.25;
  std::map<Place, std::size_t> known_;  ///< numbers in out_.tried
  SearchResult out_;
};

}  // namespace

bool Assessment::failed() const {
  return !std::isfinite(objective) || std::ranges::any_of(excess, [](double e) { return !std::isfinite(e); });
}

bool Assessment::feasible() const {
  return !failed() && std::ranges::all_of(excess, [](double e) { return e <= 0.0; });
}

std::vector<std::size_t> spread_best(const SearchPlan& plan, const std::vector<Tried>& tried) {
  const auto same = [&](const Place& a, const Place& b) {
    for (std::size_t d = 0; d < a.size(); ++d)
      if (plan.values[d] > 0 ? a[d] != b[d] : std::abs(a[d] - b[d]) > kSamePlace) return false;
    return true;
  };
  std::vector<std::size_t> order, out;
  for (std::size_t i = 0; i < tried.size(); ++i)
    if (tried[i].assessment.feasible()) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return tried[i].assessment.objective; });
  for (const std::size_t i : order)
    if (std::ranges::none_of(out, [&](std::size_t o) { return same(tried[o].place, tried[i].place); }))
      out.push_back(i);
  return out;
}

SearchResult search(const SearchPlan& plan, const Assess& assess) {
  FT_CHECK(!plan.values.empty() && plan.evaluations > 0, "something to choose, and a budget");
  return Search(plan, assess).run();
}

}  // namespace fringetwin::study
