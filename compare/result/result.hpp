// SPDX-License-Identifier: Apache-2.0
// Holds everything that one comparison of a real with a simulated side found, table by table.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// The tables in the order of result.json, the verdict on the limits, and the warnings.
struct Comparison {
  std::vector<FitRow> fits;
  std::vector<Indicator> indicators;
  std::vector<GainRow> gain;
  std::vector<GrayRow> gray;
  std::vector<GrayBudget> gray_budget;
  std::vector<PhaseRow> phase;
  std::vector<PhaseBudget> phase_budget;
  std::vector<NoiseRow> noise;
  std::vector<ShiftRow> shift;
  std::vector<ExplainedRow> explained;
  Causes causes;
  std::optional<Refinement> refinement;
  std::vector<LimitRow> limits;
  bool pass = true;
  std::vector<std::string> warnings;
};

}  // namespace fringetwin::compare
