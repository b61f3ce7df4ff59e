// SPDX-License-Identifier: Apache-2.0
#include "study/engine/worker_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

[[noreturn]] void fail(int error) {
  throw UserError(
      ExitCode::device, "study", fmt::format("cannot start a worker ({})", std::strerror(error)),
      "what is finished is safe: run the command again when the machine has room, or with less --jobs");
}

std::vector<std::string> merged_environment(const std::vector<std::string>& own) {
  const auto same_name = [](const std::string& a, const std::string& b) {
    return a.substr(0, a.find('=')) == b.substr(0, b.find('='));
  };
  std::vector<std::string> all = own;
  for (char** entry = environ; *entry; ++entry)
    if (std::ranges::none_of(own, [&](const std::string& o) { return same_name(o, *entry); }))
      all.emplace_back(*entry);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (std::string& t : texts) out.push_back(t.data());
  out.push_back(nullptr);
  return out;
}

/// Appends what is there without waiting; false at the end.
bool drain(int fd, std::string* buffer) {
  std::array<char, 65536> chunk{};
  for (;;) {
    const ssize_t n = read(fd, chunk.data(), chunk.size());
    if (n > 0) {
      buffer->append(chunk.data(), static_cast<std::size_t>(n));
    } else if (n == 0) {
      return false;
    } else if (errno != EINTR) {
      return errno == EAGAIN;
    }
  }
}

std::vector<std::string> take_lines(std::string* buffer) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end; (end = buffer->find('\n', begin)) != std::string::npos; begin = end + 1)
    lines.push_back(buffer->substr(begin, end - begin));
  buffer->erase(0, begin);
  return lines;
}

}  // namespace

WorkerProcess::WorkerProcess(const std::vector<std::string>& command,
                             const std::vector<std::string>& environment) {
  std::array<int, 2> talk{}, errors{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, talk.data()) != 0) fail(errno);
  if (pipe2(errors.data(), O_CLOEXEC) != 0) {
    const int error = errno;
    for (const int fd : talk) close(fd);
    fail(error);
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, talk[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, talk[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors[1], STDERR_FILENO);
  // The worker gets a process group of its own: Ctrl-C in a terminal reaches only us, and we then end it.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::vector<std::string> arguments = command, variables = merged_environment(environment);
  const int error = posix_spawn(&pid_, arguments.front().c_str(), &actions, &attributes,
                                pointers(arguments).data(), pointers(variables).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(talk[1]);
  close(errors[1]);
  talk_ = talk[0];
  errors_ = errors[0];
  if (error != 0) {
    close(talk_);
    close(errors_);
    fail(error);
  }
  for (const int fd : {talk_, errors_}) fcntl(fd, F_SETFL, O_NONBLOCK);
}

WorkerProcess::~WorkerProcess() {
  close(talk_);
  close(errors_);
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool WorkerProcess::send(const std::string& line) {
  const std::string text = line + '\n';
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::send(talk_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n >= 0) {
      sent += static_cast<std::size_t>(n);
    } else if (errno == EAGAIN) {
      pollfd wait{talk_, POLLOUT, 0};
      poll(&wait, 1, -1);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

void WorkerProcess::stop() { shutdown(talk_, SHUT_WR); }

std::vector<std::string> WorkerProcess::answers(bool* ended) {
  *ended = !drain(talk_, &answers_buffer_);
  return take_lines(&answers_buffer_);
}

std::vector<std::string> WorkerProcess::errors() {
  drain(errors_, &errors_buffer_);
  return take_lines(&errors_buffer_);
}

std::string WorkerProcess::end() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  if (WIFSIGNALED(status))
    return fmt::format("was killed by signal {} ({}){}", WTERMSIG(status), strsignal(WTERMSIG(status)),
                       WTERMSIG(status) == SIGKILL ? ", perhaps for want of memory" : "");
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

}  // namespace fringetwin::study
