// SPDX-License-Identifier: Apache-2.0
// Writes what a run has made: the simulated capture set, and the comparison with its report and its maps.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "compare/result/provenance.hpp"
#include "compare/result/rows.hpp"
#include "cosim/extra_files.hpp"
#include "cosim/run.hpp"

namespace fringetwin::cosim {

/// The command and the program that a result comes from.
struct Origin {
  std::vector<std::string> argv;
  std::string version;
};

/// Returns what a result says about where it comes from, with the digests of all inputs: it reads them once
/// more. `capture_files`: what was read besides the twin's own files.
compare::Provenance make_provenance(const Origin& origin, const Twin& twin,
                                    const std::vector<std::filesystem::path>& capture_files,
                                    const Rendering& rendering = {});

/// Writes the simulated capture set; with `irradiance` (may be null) the EXR images too, described by
/// DIR/radiance/capture.toml. The capture.toml go first and come back last, so that a broken-off run leaves
/// no mix of old and new images that looks complete.
void write_simulated(const std::filesystem::path& dir, const Twin& twin,
                     const std::vector<CameraImages>& captures, const std::vector<CameraImages>* irradiance,
                     const Rendering& rendering);

/// Writes what run_cosim() made besides a comparison: DIR/simulated, with the EXR images where `radiance` is
/// asked for, and refined.toml where the twin was refined. An earlier run's result.json goes first.
void write_simulated_side(const std::filesystem::path& dir, Run& run, bool radiance);

/// Compares the two sides of a run, and writes their measurements, the report with its maps and, last,
/// result.json; before it what `extra` asks for. Throws Cancelled.
compare::Comparison compare_and_write(const std::filesystem::path& dir, Run& run, const Origin& origin,
                                      const ExtraFiles& extra = {});

}  // namespace fringetwin::cosim
