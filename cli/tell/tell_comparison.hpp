// SPDX-License-Identifier: Apache-2.0
// Tells the user on stderr what a comparison has found, and chooses the program's exit code from it.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "cosim/run.hpp"

namespace fringetwin::cli {

/// Prints warnings, summary, the answer, verdict, what to do next and the place of the report in `dir`.
/// Returns the exit code: 0 when all limits are met, 1 when not, 5 when a fit of the run did not converge.
int tell_comparison(const std::filesystem::path& dir, const cosim::Run& run,
                    const compare::Comparison& comparison, const std::vector<std::string>& argv);

/// Returns 5 and prints a warning when a fit with enough points did not converge; returns `otherwise` when
/// all did.
int convergence_exit_code(const measure::Measurement& measurement, int otherwise);

}  // namespace fringetwin::cli
