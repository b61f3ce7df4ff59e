// SPDX-License-Identifier: Apache-2.0
// Runs independent jobs on all threads and carries their exceptions, and Ctrl-C, to the caller.
#pragma once
#include <functional>

namespace fringetwin {

/// Runs job(0) ... job(n-1) on all threads; then rethrows the fault of the lowest index, so that the
/// message does not depend on timing. Jobs behind a fault that have not begun are left out. Throws Cancelled.
void for_each_parallel(int n, const std::function<void(int)>& job);

}  // namespace fringetwin
