// SPDX-License-Identifier: Apache-2.0
// Progress on stderr (a bar on a terminal, else a line per 10 %), warnings, and Ctrl-C.
#pragma once
#include <cstddef>
#include <string>

namespace fringetwin {

class Progress {
 public:
  Progress(std::string task, std::size_t total);
  ~Progress();
  /// Thread-safe. Throws Cancelled once the user pressed Ctrl-C.
  void advance(std::size_t n = 1);

 private:
  std::string task_;
  std::size_t total_, done_ = 0;
  int shown_percent_ = -1;
};

/// Installs the SIGINT handler that makes cancelled() true (second Ctrl-C kills).
void install_cancel_handler();
bool cancelled();
/// Throws Cancelled if the user pressed Ctrl-C.
void throw_if_cancelled();

/// One line on stderr: "fringetwin: ..." / "fringetwin: warning: ...". set_quiet(true) mutes say().
void say(const std::string& line);
void warn(const std::string& line);
void set_quiet(bool quiet);

}  // namespace fringetwin
