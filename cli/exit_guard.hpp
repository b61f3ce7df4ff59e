// SPDX-License-Identifier: Apache-2.0
// Gives a sentence and an exit code of ours where a library ends the program: OpenMP without a thread, the
// compiler of a Vulkan driver without memory. They call exit(1), which would say that a limit is not met.
#pragma once
#include "twin/base/not_copyable.hpp"

namespace fringetwin::cli {

/// Lives as long as main() runs. One at a time.
class ExitGuard : NotCopyable {
 public:
  ExitGuard();
  ~ExitGuard();
};

}  // namespace fringetwin::cli
