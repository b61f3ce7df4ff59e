// SPDX-License-Identifier: Apache-2.0
// Puts what a refinement has found into a twin.toml: `cosim --refine ... --into twin.toml`.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cosim/run.hpp"

namespace fringetwin::cosim {

/// Throws UserError(usage) where the file has no place for what a refinement of the twin may find, or where
/// nothing is refined; before the work.
void check_refined_into_twin(const Twin& twin, const std::vector<std::string>& refine,
                             const std::filesystem::path& into);

/// Puts the refined values of a run into the file, and says so. Nothing where the refinement was taken back
/// or has not converged, which is said as well. `dir`: where the run's refined.toml is, and the textures
/// beside it. Throws as merge_into_twin().
void put_refined_into_twin(const std::filesystem::path& dir, const Run& run,
                           const std::filesystem::path& into);

}  // namespace fringetwin::cosim
