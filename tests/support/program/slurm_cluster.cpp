// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/slurm_cluster.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/twin/child_process.hpp"

namespace fringetwin::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Two ports that were free a moment ago.
std::array<int, 2> free_ports() {
  std::array<int, 2> sockets{}, ports{};
  for (std::size_t i = 0; i < 2; ++i) {
    sockets[i] = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(sockets[i], reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        getsockname(sockets[i], reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no free port");
    ports[i] = ntohs(address.sin_port);
  }
  for (const int s : sockets) close(s);
  return ports;
}

std::string daemon_path(const std::string& name) {
  for (const char* folder : {"/usr/sbin", "/usr/local/sbin", "/usr/bin", "/usr/local/bin"})
    if (access((std::string(folder) + "/" + name).c_str(), X_OK) == 0)
      return std::string(folder) + "/" + name;
  throw std::runtime_error(name + " is missing (packages.txt names its package)");
}

std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> all;
  std::ifstream list(fmt::format("/proc/{}/task/{}/children", parent, parent));
  for (pid_t p; list >> p;) all.push_back(p);
  return all;
}

void kill_descendants(pid_t parent) {
  for (const pid_t child : children_of(parent)) {
    kill_descendants(child);
    kill(child, SIGKILL);
  }
}

void start_daemon(const std::vector<std::string>& command, const fs::path& log) {
  if (fork() != 0) return;
  const int fd = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  for (const int to : {STDOUT_FILENO, STDERR_FILENO}) dup2(fd, to);
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  execv(words[0], words.data());
  _exit(127);
}

/// Starts the daemons; when nobody holds the lifeline any more, ends them and all they have started, wherever
/// that has put itself in the tree of processes.
[[noreturn]] void keep(const std::vector<std::vector<std::string>>& commands, const fs::path& log,
                       int lifeline) {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  setsid();
  for (int fd = 3; fd < 256; ++fd)
    if (fd != lifeline) close(fd);
  for (const auto& command : commands) {
    start_daemon(command, log);
    usleep(300'000);  // munge first
  }
  char nothing = 0;
  while (read(lifeline, &nothing, 1) < 0 && errno == EINTR) {
  }
  for (int round = 0; round < 100; ++round) {
    kill_descendants(getpid());
    while (waitpid(-1, nullptr, WNOHANG) > 0) {
    }
    if (children_of(getpid()).empty()) break;
    usleep(50'000);
  }
  _exit(0);
}

}  // namespace

SlurmCluster::SlurmCluster(fs::path folder) : folder_(std::move(folder)) {
  const std::string munge = daemon_path("munged"), controller = daemon_path("slurmctld"),
                    node = daemon_path("slurmd");
  for (const char* command : {"sbatch", "squeue", "scancel", "scontrol", "sinfo"}) daemon_path(command);
  write_configuration();
  const std::string f = folder_.string(), conf = configuration().string();
  const std::vector<std::vector<std::string>> commands{
      {munge, "--foreground", "--force", "--socket=" + f + "/munge.socket", "--key-file=" + f + "/munge.key",
       "--pid-file=" + f + "/munged.pid", "--log-file=" + f + "/munged.log", "--seed-file=" + f + "/seed"},
      {controller, "-D", "-f", conf},
      {node, "-D", "-f", conf}};
  std::array<int, 2> lifeline{};
  if (pipe2(lifeline.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  keeper_ = fork();
  if (keeper_ == 0) keep(commands, folder_ / "daemons.log", lifeline[0]);
  close(lifeline[0]);
  lifeline_ = lifeline[1];
  for (int attempt = 0; attempt < 100; ++attempt) {
    if (command("sinfo -h -o %T 2>/dev/null") == "idle\n") return;
    std::this_thread::sleep_for(200ms);
  }
  stop();
  throw std::runtime_error("no node is ready: " + read_file(folder_ / "daemons.log"));
}

SlurmCluster::~SlurmCluster() { stop(); }

void SlurmCluster::stop() {
  close(lifeline_);
  waitpid(keeper_, nullptr, 0);
}

std::string SlurmCluster::command(const std::string& line) const {
  return testing::run("SLURM_CONF='" + configuration().string() + "' " + line).output;
}

void SlurmCluster::write_configuration() {
  for (const char* name : {"state", "spool"}) fs::create_directories(folder_ / name);
  write_file(folder_ / "munge.key", std::string(512, 'k') + folder_.string());  // of this folder only
  fs::permissions(folder_ / "munge.key", fs::perms::owner_read);
  const passwd* user = getpwuid(geteuid());
  std::array<char, 256> host{};
  if (user == nullptr || gethostname(host.data(), host.size() - 1) != 0)
    throw std::runtime_error("this user or this machine has no name");
  const std::string name = std::string(host.data()).substr(0, std::string(host.data()).find('.'));
  const std::array ports = free_ports();
  const auto text = [&](int controller_port) {
    return fmt::format(R"(ClusterName=test
SlurmctldHost={0}(127.0.0.1)
SlurmctldPort={1}
SlurmdPort={2}
SlurmUser={3}
SlurmdUser={3}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={4}/munge.socket,cred_expire=5
StateSaveLocation={4}/state
SlurmdSpoolDir={4}/spool
SlurmctldPidFile={4}/slurmctld.pid
SlurmdPidFile={4}/slurmd.pid
SlurmctldLogFile={4}/slurmctld.log
SlurmdLogFile={4}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1
SlurmdParameters=config_overrides
ReturnToService=2
MailProg=/bin/true
KillWait=5
NodeName={0} NodeAddr=127.0.0.1 CPUs=2 RealMemory=8000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
)",
                       name, controller_port, ports[1], user->pw_name, folder_.string());
  };
  write_file(configuration(), text(ports[0]));
  write_file(dead_configuration(), text(1) + "MessageTimeout=2\n");
}

}  // namespace fringetwin::testing
