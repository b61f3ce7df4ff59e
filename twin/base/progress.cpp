// SPDX-License-Identifier: Apache-2.0
#include "twin/base/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <string_view>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"

namespace fringetwin {
namespace {

std::atomic<int> cancel_request{0};
static_assert(std::atomic<int>::is_always_lock_free, "written by a signal handler");
std::atomic<bool> quiet_mode{false}, verbose_mode{false};
/// Keeps lines of different threads whole; also guards `bar_open`.
std::mutex stderr_mutex;
bool bar_open = false;

/// Caller holds stderr_mutex. A message must not run into a half-drawn bar.
void clear_bar() {
  if (bar_open) std::fputs("\r\033[K", stderr);
  bar_open = false;
}

/// Warnings about doubtful pixels have 800 characters.
constexpr std::size_t kLongestNarration = 2000;

void print_line(const char* prefix, const std::string& line) {
  const std::lock_guard lock(stderr_mutex);
  std::fflush(stdout);  // both may go to one file: what was printed before stands before
  clear_bar();
  std::fputs((prefix + plain_sentence(line, kLongestNarration) + "\n").c_str(), stderr);
}

std::atomic<int> may_end_at_once{0};

extern "C" void on_interrupt(int signal) {
  cancel_request.store(signal);
  if (may_end_at_once.load() == 0) return;
  constexpr std::string_view kLine = "fringetwin: error: cancelled by the user\n";
  (void)!::write(STDERR_FILENO, kLine.data(), kLine.size());
  ::_exit(130);
}

extern "C" void on_interrupt_in_scope(int signal) { cancel_request.store(signal); }

}  // namespace

std::string rough_time(double seconds) {
  const auto s = std::llround(seconds);
  if (s < 90) return std::to_string(s) + " s";
  const auto minutes = (s + 30) / 60;
  if (minutes < 90) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + std::to_string(minutes % 60) + " min";
}

Progress::Progress(std::string task, std::size_t total, bool time_left, std::size_t done)
    : task_(std::move(task)),
      total_(std::max<std::size_t>(total, 1)),
      done_before_(std::min(done, total_)),
      done_(done_before_),
      terminal_(isatty(STDERR_FILENO) == 1),
      time_left_(time_left),
      shown_percent_(percent_of(done_before_)) {}

/// Rounds down to what is shown: whole percents on a terminal, else tens.
int Progress::percent_of(std::size_t done) const {
  const int every = terminal_ ? 1 : 10;
  return static_cast<int>(100.0 * static_cast<double>(done) / static_cast<double>(total_)) / every * every;
}

Progress::~Progress() {
  if (!terminal_) return;
  const std::lock_guard lock(stderr_mutex);
  clear_bar();
}

void Progress::advance(std::size_t n) {
  if (!tick(n)) throw Cancelled();
}

bool Progress::tick(std::size_t n) noexcept {
  const std::size_t done = std::min(total_, done_.fetch_add(n) + n);
  const int percent = percent_of(done);
  int shown = shown_percent_.load();
  while (percent > shown) {
    if (shown_percent_.compare_exchange_weak(shown, percent)) {
      if (!quiet_mode.load()) show(percent);
      break;
    }
  }
  return !cancelled();
}

void Progress::show(int percent) {
  const std::lock_guard lock(stderr_mutex);
  if (percent < shown_percent_.load()) return;  // another thread is further and has printed
  std::string left;
  if (time_left_ && percent > 0 && percent < 100) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    const std::size_t done = std::min(total_, done_.load());
    if (done > done_before_)
      left = ", " +
             rough_time(passed.count() * static_cast<double>(total_ - done) /
                        static_cast<double>(done - done_before_)) +
             " left";
  }
  if (!terminal_) {
    std::fprintf(stderr, "fringetwin: %s %d %%%s\n", task_.c_str(), percent, left.c_str());
    return;
  }
  constexpr int kWidth = 40;
  std::string bar(static_cast<std::size_t>(percent * kWidth / 100), '#');
  bar.resize(kWidth, '.');
  std::fprintf(stderr, "\r%s [%s] %3d %%%s\033[K", task_.c_str(), bar.c_str(), percent, left.c_str());
  std::fflush(stderr);
  bar_open = true;
}

void install_cancel_handler() {
  struct sigaction action = {};
  action.sa_handler = on_interrupt;
  sigemptyset(&action.sa_mask);
  // RESETHAND: the second Ctrl-C meets the default action and kills.
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  FT_CHECK(sigaction(SIGINT, &action, nullptr) == 0, "cannot install the SIGINT handler");
  // The end of a session or a terminal: devices are put back as they were. Not where nohup has it ignored.
  for (const int signal : {SIGTERM, SIGHUP}) {
    struct sigaction before = {};
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
      FT_CHECK(sigaction(signal, &action, nullptr) == 0, "cannot install a signal's handler");
  }
}

bool cancelled() noexcept { return cancel_signal() != 0; }
int cancel_signal() noexcept { return cancel_request.load(); }

void throw_if_cancelled() {
  if (cancelled()) throw Cancelled();
}

CancelScope::CancelScope() {
  cancel_request.store(0);
  struct sigaction action = {};
  action.sa_handler = on_interrupt_in_scope;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  FT_CHECK(sigaction(SIGINT, &action, &before_) == 0, "cannot install the SIGINT handler");
}
CancelScope::~CancelScope() {
  sigaction(SIGINT, &before_, nullptr);
  cancel_request.store(0);
}

EndsOnCancel::EndsOnCancel() {
  ++may_end_at_once;
  if (!cancelled()) return;
  --may_end_at_once;
  throw Cancelled();
}
EndsOnCancel::~EndsOnCancel() { --may_end_at_once; }

void say(const std::string& line) {
  if (!quiet_mode.load()) print_line("fringetwin: ", line);
}

void warn(const std::string& line) { print_line("fringetwin: warning: ", line); }

void set_quiet(bool quiet) { quiet_mode.store(quiet); }

void say_more(const std::string& line) {
  if (verbose_mode.load()) say(line);
}

void set_verbose(bool verbose) { verbose_mode.store(verbose); }

}  // namespace fringetwin
