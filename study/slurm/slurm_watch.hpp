// SPDX-License-Identifier: Apache-2.0
// Watches a job array of Slurm to its end: looks at the queue, and lets the caller take over what is
// finished.
#pragma once
#include <functional>
#include <string>

#include "study/slurm/slurm.hpp"

namespace fringetwin::study {

/// Returns when no point is left, or Slurm has no task of the job any more. `collect`: takes over what the
/// tasks have finished, and returns whether points are left. Throws Cancelled, and what `collect` throws.
void watch_round(slurm::Watch* watch, const std::string& job_name, const std::function<bool()>& collect);

}  // namespace fringetwin::study
