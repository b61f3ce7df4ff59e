// SPDX-License-Identifier: Apache-2.0
// Tells what a run has found, on stderr, and chooses the exit code from it.
#pragma once
#include <filesystem>

#include "compare/result/rows.hpp"
#include "cosim/run.hpp"

namespace fringetwin::cli {

/// Says the summary of a comparison that was written to `dir`, and its verdict; returns the exit code.
int tell_comparison(const std::filesystem::path& dir, const cosim::Run& run,
                    const compare::Comparison& comparison);

/// Returns 5, with a warning, when a fit with enough points did not converge, else `otherwise`.
int exit_code_for(const measure::Measurement& measurement, int otherwise);

}  // namespace fringetwin::cli
