// SPDX-License-Identifier: Apache-2.0
#include "report/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/progress.hpp"

extern char** environ;

namespace fringetwin::report {
namespace {

/// A close-on-exec socket pair; unlike a pipe it can be written without the risk of SIGPIPE.
class SocketPair : NotCopyable {
 public:
  SocketPair() { valid_ = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fd_.data()) == 0; }
  ~SocketPair() {
    close_mine();
    close_theirs();
  }
  bool valid() const { return valid_; }
  int mine() const { return fd_[0]; }
  int theirs() const { return fd_[1]; }
  void close_mine() { close_one(fd_[0]); }
  void close_theirs() { close_one(fd_[1]); }

 private:
  static void close_one(int& fd) {
    if (fd >= 0) ::close(fd);
    fd = -1;
  }
  std::array<int, 2> fd_{-1, -1};
  bool valid_ = false;
};

void receive(SocketPair& from, std::string& into) {
  std::array<char, 65536> buffer;
  const ssize_t n = ::recv(from.mine(), buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (n > 0)
    into.append(buffer.data(), static_cast<std::size_t>(n));
  else if (n == 0 || (errno != EAGAIN && errno != EINTR))
    from.close_mine();
}

void send_some(SocketPair& to, const std::string& input, std::size_t& sent) {
  const ssize_t n = ::send(to.mine(), input.data() + sent, input.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (n > 0) sent += static_cast<std::size_t>(n);
  const bool broken = n < 0 && errno != EAGAIN && errno != EINTR;
  if (broken || sent == input.size()) to.close_mine();
}

constexpr std::size_t kMostProcessOutput = std::size_t{256} << 20;  // the largest plots have some MiB
constexpr int kProcessPollMs = 100;  // how soon Ctrl-C is noticed at the latest
constexpr const char* kCancelled = "was cancelled";
constexpr std::chrono::milliseconds kPatienceWhenCancelled{5000};  // after Ctrl-C nobody waits for what hangs

/// Says when a process has to be ended.
class Patience {
 public:
  explicit Patience(std::chrono::milliseconds longest)
      : until_(std::chrono::steady_clock::now() +
               (was_cancelled_ ? std::min(longest, kPatienceWhenCancelled) : longest)) {}

  /// Sets result.killed_for where it has to.
  bool ends(ProcessResult& result) const {
    if (cancelled() && !was_cancelled_) result.killed_for = kCancelled;
    if (std::chrono::steady_clock::now() > until_) result.killed_for = "did not end";
    if (result.out.size() + result.err.size() > kMostProcessOutput) result.killed_for = "writes without end";
    return !result.killed_for.empty();
  }

 private:
  bool was_cancelled_ = cancelled();  // what tidies up after a Ctrl-C is not stopped by it
  std::chrono::steady_clock::time_point until_;
};

/// Moves the texts until the process has closed its ends, or has to be ended.
void pump(SocketPair& in, SocketPair& out, SocketPair& err, const std::string& input,
          const Patience& patience, ProcessResult& result) {
  std::size_t sent = 0;
  if (input.empty()) in.close_mine();
  while ((out.mine() >= 0 || err.mine() >= 0) && !patience.ends(result)) {
    std::array<pollfd, 3> wait{
        {{in.mine(), POLLOUT, 0}, {out.mine(), POLLIN, 0}, {err.mine(), POLLIN, 0}}};  // fd < 0 is skipped
    if (::poll(wait.data(), wait.size(), kProcessPollMs) < 0) continue;
    if (wait[0].revents != 0) send_some(in, input, sent);
    if (wait[1].revents != 0) receive(out, result.out);
    if (wait[2].revents != 0) receive(err, result.err);
  }
}

/// Waits for the process, which may live on after it has closed its ends. Returns its status as in
/// ProcessResult.
int wait_for(pid_t pid, const Patience& patience, ProcessResult& result) {
  for (;;) {
    const bool ends = patience.ends(result);
    if (ends) ::kill(-pid, SIGKILL);  // and all that it has started
    int status = 0;
    const pid_t ended = ::waitpid(pid, &status, ends ? 0 : WNOHANG);
    if (ended == pid) return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (ended < 0 && errno != EINTR) return 0;  // SIGCHLD is ignored: nobody knows
    if (ended == 0) ::usleep(1000);
  }
}

}  // namespace

std::optional<ProcessResult> run_process(const std::vector<std::string>& argv, const std::string& input,
                                         std::chrono::milliseconds longest) {
  const Patience patience(longest);  // before there is a process: a Ctrl-C as soon as it runs ends it
  SocketPair in, out, err;
  if (!in.valid() || !out.valid() || !err.valid()) return std::nullopt;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.theirs(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.theirs(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.theirs(), STDERR_FILENO);
  std::vector<char*> words;
  for (const std::string& word : argv) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_t pid = 0;
  posix_spawnattr_t group;  // its own: whoever ends it ends what it has started, too
  posix_spawnattr_init(&group);
  posix_spawnattr_setflags(&group, POSIX_SPAWN_SETPGROUP);
  const int failed = ::posix_spawnp(&pid, words[0], &actions, &group, words.data(), environ);
  posix_spawnattr_destroy(&group);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    errno = failed;
    return std::nullopt;
  }
  in.close_theirs();
  out.close_theirs();
  err.close_theirs();

  ProcessResult result;
  pump(in, out, err, input, patience, result);
  result.status = wait_for(pid, patience, result);
  if (result.killed_for == kCancelled) throw Cancelled();
  return result;
}

}  // namespace fringetwin::report
