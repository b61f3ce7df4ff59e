// SPDX-License-Identifier: Apache-2.0
// Searches where in a box an expensive function is least under constraints, within a number of evaluations:
// Sobol's points over the whole box, then COBYLA along what is continuous and steps along what is listed, in
// turns, from the best so far (docs/metrics/study.md, "Optimise").
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "twin/base/constants.hpp"

namespace fringetwin::study {

/// A place in the unit cube, one number per dimension.
using Place = std::vector<double>;

struct SearchPlan {
  /// Per dimension: 0, continuous; or so many values in equal shares of [0, 1], whose middles are taken.
  std::vector<std::size_t> values;
  std::size_t constraints = 0;
  std::size_t evaluations = 60;  ///< at most
  std::uint64_t seed = 1;
  std::function<bool(const Place&)> allowed = {};  ///< what may be assessed at all; empty: everything
  /// Places that are tried before any other, best first: once `enough` of them are feasible, nothing else
  /// is; otherwise with half of the budget.
  std::vector<Place> first = {};
  std::size_t enough = 5;
};

/// What is known of a place. NaN in any of them: it has failed, and is never the best.
struct Assessment {
  double objective = kNaN;
  std::vector<double> excess;  ///< per constraint: at most 0 where it holds

  bool failed() const;
  bool feasible() const;
};

struct Tried {
  Place place;
  std::string phase;  ///< "screened", "global", "local", "steps"
  Assessment assessment;
};
struct SearchResult {
  std::vector<Tried> tried;         ///< in the order of their evaluation; no place twice
  std::optional<std::size_t> best;  ///< of the feasible ones
};

/// Places that are assessed together, and the number of the first; an answer for each.
using Assess = std::function<std::vector<Assessment>(const std::vector<Place>&, std::size_t first)>;

/// Returns what was tried, always the same for the same answers. Exceptions of `assess` pass.
SearchResult search(const SearchPlan& plan, const Assess& assess);

/// Returns the feasible ones by rising objective, without those that lie within 1/50 of the box of a better
/// one along every range and have its listed values.
std::vector<std::size_t> spread_best(const SearchPlan& plan, const std::vector<Tried>& tried);

}  // namespace fringetwin::study
