// SPDX-License-Identifier: Apache-2.0
// Shows progress (a bar on a terminal, else a line per 10 %) and warnings on stderr, and notices Ctrl-C.
#pragma once
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <string>

#include "twin/base/not_copyable.hpp"

namespace fringetwin {

/// Returns a duration in words: "40 s", "5 min", "3 h 20 min".
std::string rough_time(double seconds);

/// One task of `total` equal pieces. Shows nothing when set_quiet(true).
class Progress : NotCopyable {
 public:
  /// `time_left`: says how long the rest will take, going by what is done. `done`: pieces that had been done
  /// before, by an earlier run or stage.
  Progress(std::string task, std::size_t total, bool time_left = false, std::size_t done = 0);
  ~Progress();
  /// Thread-safe. Throws Cancelled once the user pressed Ctrl-C; an exception must not leave an OpenMP
  /// region, so inside one use tick() and call throw_if_cancelled() after it.
  void advance(std::size_t n = 1);
  /// As advance(), but returns false instead of throwing.
  bool tick(std::size_t n = 1) noexcept;

 private:
  int percent_of(std::size_t done) const;
  void show(int percent);

  std::string task_;
  std::size_t total_, done_before_;
  std::atomic<std::size_t> done_;
  bool terminal_, time_left_;
  std::atomic<int> shown_percent_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Installs the SIGINT handler that makes cancelled() true (second Ctrl-C kills).
void install_cancel_handler();
bool cancelled() noexcept;
/// The signal that asked for it (SIGINT, SIGTERM, SIGHUP); 0 before.
int cancel_signal() noexcept;
/// Throws Cancelled if the user pressed Ctrl-C.
void throw_if_cancelled();

/// Cancels long calls in a process that is not the program's own, as Python's. While it lives a Ctrl-C makes
/// cancelled() true and kills nothing; afterwards the handler from before is there again, and nothing is
/// cancelled any more. One at a time.
class CancelScope : NotCopyable {
 public:
  CancelScope();
  ~CancelScope();

 private:
  struct sigaction before_;
};

/// While it lives a Ctrl-C ends the process at once, with exit code 130: for calls of libraries that may take
/// long and write no files. Its constructor throws Cancelled where it came before.
class EndsOnCancel : NotCopyable {
 public:
  EndsOnCancel();
  ~EndsOnCancel();
};

/// One line of plain text (plain_text.hpp) on stderr: "fringetwin: ..." / "fringetwin: warning: ...".
/// set_quiet(true) mutes say().
void say(const std::string& line);
void warn(const std::string& line);
void set_quiet(bool quiet);
/// As say(), of what only who asks for it wants to know: muted unless set_verbose(true).
void say_more(const std::string& line);
void set_verbose(bool verbose);

}  // namespace fringetwin
