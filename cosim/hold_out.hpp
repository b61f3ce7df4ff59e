// SPDX-License-Identifier: Apache-2.0
// Predicts the real images of each fold of the phase steps from a twin that was fitted to the other folds.
#pragma once
#include <string>
#include <vector>

#include "cosim/run.hpp"

namespace fringetwin::cosim {

/// Returns what is dealt to the folds by its name, "steps" or "pitches". Throws UserError(usage) for another.
HeldOutBy held_out_by(const std::string& name);

/// Throws UserError(usage) where images are to be held out that are not there, or that cannot be dealt to so
/// many folds, or of which something is asked that nothing but themselves would tell.
void check_hold_out(const Run& run, const std::vector<std::string>& asked);

/// Fills run.options.held_out where the twin's [compare] asks for it, with what is asked for fitted in
/// every fold; a measured object is built and rendered anew from the steps that are fitted. To be called with
/// both sides measured and nothing refined yet.
void hold_out(Run& run, const RenderRequest& render, const std::vector<std::string>& asked);

}  // namespace fringetwin::cosim
