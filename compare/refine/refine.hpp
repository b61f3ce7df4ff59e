// SPDX-License-Identifier: Apache-2.0
// Fits the parameters that `cosim --refine` names to the real gray values, and returns the changed twin with
// a report of the fit (docs/metrics/causes.md, "Refinement").
#pragma once
#include <string>
#include <vector>

#include "compare/result/options.hpp"
#include "compare/result/refined.hpp"
#include "compare/result/side.hpp"
#include "twin/merge/toml_block.hpp"

namespace fringetwin::compare {

/// Whether a refinement that makes something worse is taken back (refine_guard.hpp) or stays.
enum class WhatIsWorse { taken_back, stays };

/// What tells where things are.
enum class Evidence {
  fringes,            ///< every pixel has a brightness and an offset of its own
  fringes_and_light,  ///< the twin's light is taken for right
};

/// Fits the twin by GroupFit through the renderer, on the gray values of all phase
/// steps of the interior pixels that both sides see (grid_samples), from the places that fits to the real
/// points give where those fit better. The twin stays as it is where anything gets worse
/// (refine_guard.hpp), unless it `stays`; the report has chi2 and n of the fit's own equations then. What
/// these images do not tell, or of light no better than by its own size, stays at the twin's value and has no
/// row. `asked`: groups, names of parameters ("projector.k1") or what stands before their dot ("projector").
/// Gain and black level of each camera are fitted besides and kept only where asked for; with "albedo" the
/// gain is held at the twin's, because the two enter as a product. "texture" gives every pixel a factor of
/// its own, "offset" an offset, which holds the black level at the twin's; those, and "texture_spread", are
/// told by apply_texture() after it. Places that would be taken back, or that leave
/// the light of regions alone unexplained, are fitted once more by fringes and light. `simulated`: the twin
/// as it is, rendered and measured. Throws UserError(usage) as check_refine(), for parameters that change
/// nothing and for those that the data cannot tell apart, naming them; Cancelled after Ctrl-C.
Refined refine(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
               const std::vector<std::string>& asked, WhatIsWorse worse = WhatIsWorse::taken_back,
               Evidence evidence = Evidence::fringes);

/// Returns every key that differs, with its value afterwards, in the words of twin.toml.
std::vector<TomlBlock> refined_blocks(const Twin& before, const Twin& after);
/// Returns the tables, without keys, that any refinement of the twin may have values for.
std::vector<TomlBlock> refinable_tables(const Twin& twin);

/// Returns what to write into twin.toml: refined_blocks() as text, the refined values with their standard
/// errors as comments above.
std::string refined_toml(const Refinement& refinement, const Twin& before, const Twin& after);

}  // namespace fringetwin::compare
