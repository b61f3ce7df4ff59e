// SPDX-License-Identifier: Apache-2.0
// What cosim, compare and measure do with a finished run: write it, say its verdict, choose the exit code.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/pipeline.hpp"
#include "compare/comparison.hpp"
#include "compare/result/provenance.hpp"
#include "compare/result/result_json.hpp"

namespace fringetwin::cli {

compare::Provenance make_provenance(const Invocation& invocation, const Twin& twin,
                                    const std::vector<std::filesystem::path>& more_inputs,
                                    const std::string& device, std::uint64_t seed);

/// Every file a capture folder names, for the provenance.
std::vector<std::filesystem::path> capture_files(const Twin& twin, const std::filesystem::path& dir);

/// Writes measurements, report and, last, result.json; prints the summary; returns the exit code.
int finish_comparison(const std::filesystem::path& dir, const Twin& twin, const compare::Side& real,
                      const compare::Side& simulated, const compare::CompareOptions& options,
                      const compare::Provenance& provenance, StageTimer& timer);

/// 5 when a fit with enough points did not converge, else `otherwise`.
int exit_code_for(const std::vector<measure::ObjectFit>& fits, int otherwise);

/// The sentence under a comparison of an object that was built from the capture itself.
std::string measured_shape_note(const Twin& twin, const std::vector<int>& compared_steps);

/// The sentences under a comparison with published numbers instead of images: what it shows when the
/// virtual object is the published result itself, and when it is not.
std::string published_results_note(const Twin& twin);

}  // namespace fringetwin::cli
