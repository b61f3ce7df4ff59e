// SPDX-License-Identifier: Apache-2.0
// A derivative-free local search under constraints: COBYLA (Powell 1994) of NLopt.
#pragma once
#include <functional>
#include <vector>

namespace fringetwin::study {

struct LocalValue {
  double objective = 0.0;
  std::vector<double> excess;  ///< at most 0 where a constraint holds
};

/// What a LocalFunction throws to end the search early.
struct EnoughOfIt {};
/// Finite numbers for every place in the unit cube.
using LocalFunction = std::function<LocalValue(const std::vector<double>&)>;

/// Searches the unit cube from `start` with steps of `step` down to `least_step`. The caller keeps what the
/// function saw. Other exceptions of the function pass.
void local_search(const LocalFunction& function, std::vector<double> start, std::size_t constraints,
                  double step, double least_step);

}  // namespace fringetwin::study
