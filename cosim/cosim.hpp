// SPDX-License-Identifier: Apache-2.0
// Does the main job up to the comparison: from a twin.toml to its simulated and its real side, measured
// alike.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "cosim/run.hpp"

namespace fringetwin::cosim {

struct CosimRequest {
  std::filesystem::path twin;  ///< the twin.toml
  std::map<std::string, std::string>
      settings;  ///< in the place of some of its keys, as load_twin() takes them
  std::vector<std::string>
      refine;  ///< what to fit to the real images first (compare/refine/asked_parameters.hpp)
  std::filesystem::path into = {};  ///< a twin.toml that the refined values go into; empty: none
  std::string steps;                ///< "even" | "odd": compare these phase steps; empty = all that may be
  int hold_out = 0;                 ///< folds; 0: what the twin's [compare] says
  std::string hold_out_by = {};     ///< "steps" or "pitches"; empty: what the twin's [compare] says
  RenderRequest render;
};

/// Loads the twin and its real captures, renders and exposes every camera, measures both sides and refines
/// the twin where that is asked for; then compare_and_write() (cosim/write_results.hpp) does the rest.
/// What the twin, its captures, --steps, --refine and --into can be refused for is refused before a device is
/// opened. Throws UserError and Cancelled.
Run run_cosim(const CosimRequest& request);

}  // namespace fringetwin::cosim
