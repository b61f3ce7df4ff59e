// SPDX-License-Identifier: Apache-2.0
// `study --engine slurm` on a real Slurm of one node: the table of one machine, every point once, whatever
// happens to the submitting process, the tasks and the queue.
// tolerance: none, tables are compared byte by byte.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/slurm_cluster.hpp"
#include "tests/support/program/small_twin.hpp"
#include "tests/support/program/study_folder.hpp"

namespace fringetwin::testing::study_slurm_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class StudySlurm : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    try {
      cluster_ = std::make_unique<SlurmCluster>(scratch_folder("slurm_cluster"));
      setenv("SLURM_CONF", cluster_->configuration().c_str(), 1);
    } catch (const std::runtime_error& e) {
      why_none_ = e.what();
    }
  }
  static void TearDownTestSuite() {
    unsetenv("SLURM_CONF");
    cluster_.reset();
  }
  void SetUp() override {
    FT_NEED_DEVICE();
    if (cluster_) return;
    ASSERT_EQ(std::getenv("CI"), nullptr) << why_none_;
    ASSERT_EQ(std::getenv("FRINGETWIN_REQUIRE_DEVICE"), nullptr) << why_none_;
    GTEST_SKIP() << "SKIPPED: no Slurm: " << why_none_;
  }

  static std::unique_ptr<SlurmCluster> cluster_;
  static std::string why_none_;
};
std::unique_ptr<SlurmCluster> StudySlurm::cluster_;
std::string StudySlurm::why_none_;

const std::string record = "[[record]]\nresult = \"fits.ball.measured.radius_mm\"\nname = \"radius_mm\"\n";

/// The small study of the radius.
fs::path recorded_study(const std::string& name, const std::string& study) {
  return study_folder(name, kSmallStudy + study + record);
}

/// Each with a trace of its own, some tenths of a second long.
std::string slow_points(int n) {
  std::string radii;
  for (int i = 0; i < n; ++i) radii += fmt::format("{}{:.2f}", i == 0 ? "" : ", ", 18.0 + 0.05 * i);
  return "[[vary]]\nkey = \"object.ball.radius_mm\"\nvalues = [" + radii +
         "]\n[[vary]]\nkey = \"render.samples\"\nvalues = [1024]\n";
}

/// `study --engine slurm` that can be killed while it runs.
class Submitter {
 public:
  Submitter(const fs::path& dir, const std::vector<std::string>& more) : log_(dir / "submitter.log") {
    fs::remove(log_);
    std::vector<std::string> words = study_arguments(dir, "slurm", more);
    words.insert(words.begin(), std::getenv("FRINGETWIN_BINARY"));
    std::vector<char*> pointers;
    for (std::string& w : words) pointers.push_back(w.data());
    pointers.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int fd = open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    for (const int to : {STDOUT_FILENO, STDERR_FILENO}) dup2(fd, to);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  ~Submitter() {
    if (pid_ > 0) end(SIGKILL);
  }
  Submitter(const Submitter&) = delete;
  Submitter& operator=(const Submitter&) = delete;

  std::string said() const { return read_file(log_); }
  /// 128 + signal where that was its end.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }
  int end(int signal) {
    kill(pid_, signal);
    return wait();
  }

 private:
  fs::path log_;
  pid_t pid_ = -1;
};

/// True within a minute.
bool comes(const std::function<bool()>& condition) {
  for (const auto until = std::chrono::steady_clock::now() + 60s; std::chrono::steady_clock::now() < until;) {
    if (condition()) return true;
    std::this_thread::sleep_for(20ms);
  }
  return false;
}

/// What the attempts of all rounds say.
struct Attempts {
  std::map<std::int64_t, int> finished;        ///< how often
  std::map<std::int64_t, int> begun;           ///< how often
  std::set<std::int64_t> begun_after_its_end;  ///< in the order of rounds, attempts and lines
  std::set<std::int64_t> in_progress;
  std::size_t files = 0, rounds = 0, restarts = 0;
  std::string last_round, job;
};
Attempts attempts(const fs::path& out) {
  Attempts all;
  std::map<std::string, fs::path> files;  // by round, then by shard and attempt: all below ten
  if (!fs::exists(out / "slurm")) return all;
  for (const auto& entry : fs::recursive_directory_iterator(out / "slurm")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("round-") && entry.is_directory()) {
      ++all.rounds;
      all.last_round = std::max(all.last_round, entry.path().string());
    }
    if (name.find(".attempt-") != std::string::npos) files[entry.path().string()] = entry.path();
  }
  for (const auto& [name, file] : files) {
    ++all.files;
    std::set<std::int64_t> open;
    std::istringstream lines(read_file(file));
    for (std::string line; std::getline(lines, line) && !lines.eof();) {
      const json j = json::parse(line);
      if (j.contains("attempt")) {
        all.job = j["attempt"].get<std::string>().substr(0, j["attempt"].get<std::string>().find('_'));
        all.restarts += j["restart"].get<int>() > 0 ? 1 : 0;
      } else if (j.contains("begun")) {
        const std::int64_t id = j["begun"];
        ++all.begun[id];
        open.insert(id);
        if (all.finished.contains(id)) all.begun_after_its_end.insert(id);
      } else if (j.contains("id")) {
        ++all.finished[j["id"].get<std::int64_t>()];
        open.erase(j["id"].get<std::int64_t>());
      }
    }
    all.in_progress.insert(open.begin(), open.end());
  }
  return all;
}

/// Processes of a task on the node.
std::vector<pid_t> processes(const std::string& round, int index) {
  std::vector<pid_t> all;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    std::string words = pid > 0 ? read_file(entry.path() / "cmdline") : "";
    std::replace(words.begin(), words.end(), '\0', ' ');
    if (words.find(fmt::format(" study-shard {} {} ", round, index)) != std::string::npos) all.push_back(pid);
  }
  return all;
}

TEST_F(StudySlurm, TheTableOfOneMachine) {
  const fs::path dir = recorded_study("slurm it's 5 %A", "noise_seeds = 4\n" + kRadiiAndSensors);
  const RunResult local = run_study(dir, "local"),
                  slurm = run_study(dir, "slurm", {"--engine", "slurm", "--shards", "3", "--jobs", "2"});
  ASSERT_EQ(slurm.exit_code, 0) << slurm.err;
  EXPECT_THAT(slurm.err, HasSubstr("32 points in 3 tasks"));
  EXPECT_EQ(read_file(dir / "slurm/study.csv"), read_file(dir / "local/study.csv"));
  const std::string ours = slurm.out.substr(0, slurm.out.find('\n'));
  EXPECT_EQ(ours, local.out.substr(0, local.out.find('\n')));
  EXPECT_THAT(ours, HasSubstr("24 measured, 8 failed, 32 of them in this run"));

  const Attempts all = attempts(dir / "slurm");
  EXPECT_EQ(all.finished.size(), 32U);
  EXPECT_EQ(all.files, 3U);
  EXPECT_TRUE(fs::exists(fs::path(all.last_round) / "task-2.log"));
  EXPECT_EQ(cluster_->command(fmt::format("squeue -h -j {} -t all -o '%C %m %l %r'", all.job)).substr(0, 15),
            "2 1200M 1:00:00")
      << "the resources of a task; its memory is per core";

  const RunResult again = run_study(dir, "slurm", {"--engine", "slurm"});
  EXPECT_THAT(again.out, HasSubstr("0 of them in this run"));
  EXPECT_EQ(attempts(dir / "slurm").files, 3U) << "nothing was submitted";
}

TEST_F(StudySlurm, InterruptedKilledAndRequeuedEveryPointIsMeasuredOnce) {
  constexpr int n = 48;
  const fs::path dir = recorded_study("slurm_kills", slow_points(n));
  const std::vector<std::string> options{"--engine", "slurm", "--shards", "4"};
  const auto done = [&] { return attempts(dir / "slurm").finished.size(); };
  {
    Submitter first(dir, options);
    ASSERT_TRUE(comes([&] { return done() >= 4; })) << first.said();
    EXPECT_EQ(first.end(SIGKILL), 128 + SIGKILL);
  }
  const std::size_t at_kill = done();
  EXPECT_TRUE(comes([&] { return done() > at_kill + 2; })) << "the array does not need its submitter";

  const Attempts seen = attempts(dir / "slurm");
  // shards 0 and 1 run: one dies, the other goes back into the queue
  const auto victims = processes(seen.last_round, 0);
  ASSERT_EQ(victims.size(), 1U);
  kill(victims[0], SIGKILL);
  EXPECT_EQ(cluster_->command(fmt::format("scontrol requeue {}_1 2>&1", seen.job)), "");
  {
    Submitter logged_out(dir, options);
    ASSERT_TRUE(comes([&] { return logged_out.said().find("is watched") != std::string::npos; }));
    EXPECT_EQ(logged_out.end(SIGTERM), 130);
    EXPECT_THAT(logged_out.said(), HasSubstr("goes on; the same command watches it again"));
  }
  Submitter second(dir, options);
  ASSERT_TRUE(comes([&] { return second.said().find("is watched") != std::string::npos; })) << second.said();
  EXPECT_EQ(attempts(dir / "slurm").rounds, 1U) << "submitted twice";
  ASSERT_TRUE(comes([&] { return attempts(dir / "slurm").restarts > 0; })) << second.said();
  // four tasks, one of them twice; the next is one of the array that has the rest
  ASSERT_TRUE(comes([&] { return attempts(dir / "slurm").files > 5; })) << second.said();
  EXPECT_THAT(second.said(), HasSubstr("1 task FAILED"));
  EXPECT_EQ(second.end(SIGINT), 130) << second.said();
  EXPECT_THAT(second.said(), HasSubstr("is cancelled"));
  EXPECT_THAT(second.said(), HasSubstr("the same command goes on from there"));
  EXPECT_EQ(cluster_->command("squeue -h"), "") << "nothing runs on";
  const std::size_t at_cancel = done();
  EXPECT_LT(at_cancel, static_cast<std::size_t>(n)) << "too fast to be interrupted";

  const RunResult last = run_study(dir, "slurm", options);
  ASSERT_EQ(last.exit_code, 0) << last.err;
  ASSERT_EQ(run_study(dir, "local").exit_code, 0);
  EXPECT_EQ(read_file(dir / "slurm/study.csv"), read_file(dir / "local/study.csv"));
  const Attempts all = attempts(dir / "slurm");
  ASSERT_EQ(all.finished.size(), static_cast<std::size_t>(n));
  int again = 0;
  for (const auto& [id, times] : all.finished) {
    EXPECT_EQ(times, 1) << "point " << id;
    again += all.begun.at(id) - 1;
  }
  EXPECT_TRUE(all.begun_after_its_end.empty());
  EXPECT_LE(again, 4)
      << "only what was in progress: one point of each of the four tasks that were broken off";
  std::printf("%zu attempts in %zu rounds; %d points were begun again\n", all.files, all.rounds, again);
}

TEST_F(StudySlurm, WhatTakesItsTaskAlongThreeTimesHasFailed) {
  const fs::path dir = recorded_study("slurm_deadly", R"([[vary]]
key = "render.samples"
values = [16, 65536, 64, 256]
)");
  Submitter submitter(dir, {"--engine", "slurm", "--shards", "1"});
  for (int death = 0; death < 3; ++death) {
    ASSERT_TRUE(comes([&] {
      const Attempts all = attempts(dir / "slurm");
      return all.begun.contains(1) && all.begun.at(1) == death + 1;
    })) << submitter.said();
    const std::string round = attempts(dir / "slurm").last_round;
    // alone the second time: no other point is lost by it
    const auto at = submitter.said().size();
    for (int shard = 0; shard < 2; ++shard)
      if (read_file(fs::path(round) / fmt::format("shard-{}.attempt-0.jsonl", shard)).find("\"begun\":1}") !=
          std::string::npos)
        for (const pid_t pid : processes(round, shard)) kill(pid, SIGKILL);
    ASSERT_TRUE(comes([&] { return submitter.said().size() > at; }));
  }
  EXPECT_EQ(submitter.wait(), 0) << submitter.said();
  EXPECT_THAT(submitter.said(), HasSubstr("3 measured, 1 failed"));
  EXPECT_THAT(submitter.said(), HasSubstr("points failed: 3 times its task ended FAILED ("));
}

TEST_F(StudySlurm, WithoutADeviceNoPointFails) {
  const fs::path dir = recorded_study("slurm_no_device", "noise_seeds = 5\n");
  expect_refused(run_study(dir, "slurm", {"--engine", "slurm", "--device", "no such device"}), 4,
                 {"node ", "no such device"});
  EXPECT_EQ(cluster_->command("squeue -h"), "");
  const RunResult run = run_study(dir, "slurm", {"--engine", "slurm"});
  EXPECT_THAT(run.out, HasSubstr("5 measured, 0 failed, 5 of them in this run")) << run.err;
}

TEST_F(StudySlurm, WithoutSlurmNothingIsLost) {
  const fs::path dir = recorded_study("slurm_absent", "noise_seeds = 3\n");
  const RunResult local = run_study(dir, "out");
  const std::string table = read_file(dir / "out/study.csv");
  fs::create_directories(dir / "bin");
  fs::create_symlink("/usr/bin/timeout", dir / "bin/timeout");
  const auto args = study_arguments(dir, "out", {"--engine", "slurm"});
  expect_refused(run_fringetwin(args, {"PATH=" + (dir / "bin").string()}), 2,
                 {"--engine slurm", "there is no sbatch in PATH", "--engine local"});
  expect_refused(run_fringetwin(args, {"SLURM_CONF=" + cluster_->dead_configuration().string()}), 2,
                 {"--engine slurm", "Slurm does not answer", "Unable to contact slurm controller"});
  expect_refused(run_study(dir, "new", {"--engine", "slurm", "--slurm-args", "--partition=none"}), 2,
                 {"sbatch refuses", "nvalid partition"});
  expect_refused(run_study(dir, "new", {"--engine", "slurm", "--slurm-args", "--array=0-1"}), 2,
                 {"--array is set by the program itself"});
  expect_refused(run_study(dir, "new", {"--engine", "slurm", "--slurm-args", "--time=3 -Jname"}), 2,
                 {"-J is set by the program itself"});
  expect_refused(run_study(dir, "new", {"--shards", "2"}), 2, {"--engine slurm"});
  EXPECT_EQ(read_file(dir / "out/study.csv"), table);
  const RunResult again = run_study(dir, "out");
  EXPECT_THAT(again.out, HasSubstr("0 of them in this run"));
  const RunResult after =
      run_study(dir, "new", {"--engine", "slurm", "--slurm-args", "--mem-per-cpu=900M --time=3"});
  EXPECT_EQ(after.exit_code, 0) << after.err;
  EXPECT_EQ(read_file(dir / "new/study.csv"), table);
}

TEST_F(StudySlurm, OtherKindsOfStudiesGiveTheSameResult) {
  const std::string monte_carlo = R"(kind = "monte-carlo"
block_trials = 5
least_blocks = 2
sensitivity_rows = 4
most_trials = 10
[[uncertain]]
key = "object.ball.center_mm[2]"
name = "depth"
sigma = 0.05
)" + record,
                    volume_map = R"(kind = "volume-map"
object = "ball"
center_mm = [0, 0, 270]
size_mm = [10, 0, 0]
counts = [2, 1, 1]
trials = 2
[[uncertain]]
form = "ball"
rms_mm = 0.01
)";
  for (const std::string& study : {monte_carlo, volume_map}) {
    const fs::path dir = study_folder("slurm_kinds", kSmallStudy + study);
    const int local = run_study(dir, "local").exit_code;
    const RunResult slurm = run_study(dir, "slurm", {"--engine", "slurm", "--shards", "2"});
    EXPECT_EQ(slurm.exit_code, local) << slurm.err;
    for (const char* file : {"study.csv", "result.json"})
      EXPECT_EQ(read_file(dir / "slurm" / file), read_file(dir / "local" / file));
  }
}

}  // namespace
}  // namespace fringetwin::testing::study_slurm_test
