// SPDX-License-Identifier: Apache-2.0
// Says in sentences, for the narration of a run, what a comparison or a measurement has found.
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "measure/measurement.hpp"

namespace fringetwin::cosim {

/// Returns what a comparison found, a sentence each: gains, phases, budgets, causes, fits and limits.
std::vector<std::string> summary_lines(const compare::Comparison& comparison);

/// Returns what [measure] light = "corrected" found and did, a sentence for each row.
std::vector<std::string> light_lines(const std::vector<compare::LightRow>& rows);

/// Returns the sentence on the first fit that had enough points and did not converge; empty when there is
/// none.
std::string convergence_fault(const measure::Measurement& measurement);

}  // namespace fringetwin::cosim
