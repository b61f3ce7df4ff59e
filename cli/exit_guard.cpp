// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_guard.hpp"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <string_view>

#include "twin/base/errors.hpp"

namespace fringetwin::cli {
namespace {

std::atomic<bool> in_main = false;

/// Called by exit(): nothing of the program can be relied on any more.
void end_with_a_sentence() {
  if (!in_main) return;
  constexpr std::string_view kSentence =
      "fringetwin: error: not enough memory or threads, most likely: a library has ended the program; allow "
      "more of them (ulimit -v, ulimit -u), or render fewer pixels at a time\n";
  [[maybe_unused]] const ssize_t n = ::write(STDERR_FILENO, kSentence.data(), kSentence.size());
  ::_exit(static_cast<int>(ExitCode::input));
}

}  // namespace

ExitGuard::ExitGuard() {
  [[maybe_unused]] static const int registered = std::atexit(end_with_a_sentence);
  in_main = true;
}
ExitGuard::~ExitGuard() { in_main = false; }

}  // namespace fringetwin::cli
