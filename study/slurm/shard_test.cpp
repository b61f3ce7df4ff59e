// SPDX-License-Identifier: Apache-2.0
// How a study is cut into tasks, and what is read from the files of their attempts.
// tolerance: none.
#include "study/slurm/shard.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>

#include "report/text.hpp"
#include "study/slurm/attempt_log.hpp"
#include "study/slurm/slurm.hpp"
#include "study/slurm/slurm_batch.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::shard_test {
namespace {
using namespace fringetwin::study;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

using Points = std::vector<PlannedPoint>;

/// Groups of these sizes, ids in turn.
Points groups_of(const std::vector<std::size_t>& sizes) {
  Points all;
  for (std::size_t g = 0; g < sizes.size(); ++g)
    for (std::size_t i = 0; i < sizes[g]; ++i) {
      PlannedPoint p;
      p.point = {static_cast<std::int64_t>(all.size()), {{"object.ball.radius_mm", fmt::format("{}", g)}}, i};
      p.group = g;
      p.keys = {fmt::format("trace {}", g), fmt::format("form {}", i)};
      p.demand = {{{12, 0.1}}, 0.5, 1.0 / 3.0};
      all.push_back(p);
    }
  return all;
}

std::vector<std::size_t> sizes(const std::vector<Points>& shards) {
  std::vector<std::size_t> out;
  for (const Points& s : shards) out.push_back(s.size());
  return out;
}

/// Each point once, and how many pieces the groups are in.
std::size_t pieces(const std::vector<Points>& shards, std::size_t points) {
  std::set<std::int64_t> ids;
  std::size_t n = 0, count = 0;
  for (const Points& s : shards) {
    std::set<std::size_t> groups;
    for (const PlannedPoint& p : s) {
      ids.insert(p.point.id);
      groups.insert(p.group);
    }
    count += s.size();
    n += groups.size();
  }
  EXPECT_EQ(ids.size(), points);
  EXPECT_EQ(count, points) << "a point twice";
  return n;
}

TEST(Shards, AreEquallyLargeAndKeepTracesTogether) {
  EXPECT_THAT(cut_shards({}, 4), IsEmpty());
  const auto one = cut_shards(groups_of({100}), 8);
  EXPECT_THAT(sizes(one), ::testing::Each(::testing::AllOf(::testing::Ge(12), ::testing::Le(13))));
  EXPECT_EQ(pieces(one, 100), 8U) << "one trace for all: each task makes it once";
  const auto many = cut_shards(groups_of(std::vector<std::size_t>(12, 5)), 4);
  EXPECT_THAT(sizes(many), ElementsAre(15, 15, 15, 15));
  EXPECT_EQ(pieces(many, 60), 12U) << "no trace is made twice";
  const auto mixed = cut_shards(groups_of({50, 3, 3, 3, 3, 3, 3}), 4);
  EXPECT_THAT(sizes(mixed), ::testing::Each(::testing::AllOf(::testing::Ge(13), ::testing::Le(19))));
  EXPECT_EQ(pieces(mixed, 68), 9U);
  EXPECT_THAT(sizes(cut_shards(groups_of({2, 1}), 9)), ElementsAre(1, 1, 1)) << "no task without a point";
}

TEST(Shards, ASuspectIsAlone) {
  const auto shards = cut_shards(groups_of({4, 4}), 2, {3, 5});
  EXPECT_THAT(sizes(shards), ElementsAre(3, 3, 1, 1));
  EXPECT_EQ(shards[2][0].point.id, 3);
  EXPECT_EQ(shards[3][0].point.id, 5);
  EXPECT_THAT(sizes(cut_shards(groups_of({1}), 1, {0})), ElementsAre(1));
}

TEST(Shards, AreReadAsTheyWereWritten) {
  const testing::ScratchFolder folder;
  const Points points = groups_of({2, 1});
  const WorkerTask task{{"/rig/it's \"a\" twin.toml", {{"fits.ball", "r"}}, true, false}, "llvmpipe"};
  write_shard(folder.path(), 3, {task, points});
  const Shard read = read_shard(folder.path(), 3);
  EXPECT_EQ(task_line(read.task.task, read.task.device), task_line(task.task, task.device));
  ASSERT_THAT(read.points, SizeIs(3));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(point_line(read.points[i]), point_line(points[i]));
    EXPECT_EQ(read.points[i].group, points[i].group);
    EXPECT_EQ(read.points[i].demand, points[i].demand);
  }
  std::ofstream(folder / "shard-3.jsonl", std::ios::app) << "no point\n";
  try {
    read_shard(folder.path(), 3);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr("shard-3.jsonl:5: is damaged"));
  }
  EXPECT_THROW(read_shard(folder.path(), 4), UserError);
}

TEST(Shards, OfStrangersAreRefused) {
  const testing::ScratchFolder folder;
  const std::string task = task_line({"/twin.toml", {}}, ""), point = point_line(groups_of({1})[0]);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = point;
    EXPECT_NE(changed.find(from), std::string::npos) << from;
    return task + "\n" + changed.replace(changed.find(from), from.size(), to) + "\n";
  };
  const std::string texts[] = {"",
                               "\n",
                               "[]\n",
                               task + "\n" + std::string(100'000, '[') + "\n",
                               with("[12,0.1]", "[99,0.1]"),
                               with("[12,0.1]", "[12,-1]"),
                               with("[12,0.1]", "[12,1e999]"),
                               with("[12,0.1]", "[12]"),
                               with("\"mean\":0.5", "\"mean\":1e300"),
                               with("\"seed\":0", "\"seed\":\"0\""),
                               with("\"seed\":0", "\"seed\":1e38"),
                               with("\"id\":0", "\"id\":0.5"),
                               with("\"group\":0", "\"group\":-1")};
  for (const std::string& text : texts) {
    folder.write("shard-0.jsonl", text);
    try {
      read_shard(folder.path(), 0);
      ADD_FAILURE() << text.substr(0, 300);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      EXPECT_THAT(e.what(), HasSubstr("shard-0.jsonl:"));
    }
  }
  ASSERT_EQ(::mkfifo((folder / "shard-1.jsonl").c_str(), 0600), 0);
  EXPECT_THROW(read_shard(folder.path(), 1), UserError);
  EXPECT_FALSE(has_one_point(folder.path(), 1));
}

PointOutcome outcome(std::int64_t id, double value) { return {id, false, "", {{"r", value}}, 0.5, true}; }

TEST(Attempts, AreReadWhileTheyAreWritten) {
  const testing::ScratchFolder folder;
  AttemptReader reader(folder.path());
  EXPECT_THAT(reader.read().outcomes, IsEmpty());
  AttemptLog log(folder.path(), 2, {"7_2", "node1", "1.0", 0});
  log.begun(11);
  log.finished(outcome(11, 0.1 + 0.2));
  log.begun(12);
  AttemptNews news = reader.read();
  ASSERT_THAT(news.outcomes, SizeIs(1));
  EXPECT_EQ(news.outcomes[0].id, 11);
  EXPECT_EQ(news.outcomes[0].numbers.at("r"), 0.1 + 0.2) << "to the last bit";
  EXPECT_EQ(news.outcomes[0].host, "node1");
  EXPECT_EQ(news.outcomes[0].version, "1.0");
  EXPECT_THAT(reader.broken_off(), ElementsAre(Pair(12, 2)));
  log.finished(outcome(12, std::nan("")));
  log.warning("dark");
  log.unfit("no device", 4);
  news = reader.read();
  ASSERT_THAT(news.outcomes, SizeIs(1)) << "each line once";
  EXPECT_TRUE(std::isnan(news.outcomes[0].numbers.at("r")));
  EXPECT_THAT(news.warnings, ElementsAre("dark"));
  ASSERT_TRUE(news.unfit);
  EXPECT_EQ(news.unfit->sentence, "no device");
  EXPECT_EQ(news.unfit->exit_code, 4);
  EXPECT_EQ(news.unfit->host, "node1");
  EXPECT_THAT(reader.broken_off(), IsEmpty());
}

TEST(Attempts, OfOneShardHaveAFileEach) {
  const testing::ScratchFolder folder;
  AttemptLog first(folder.path(), 0, {"7_0", "a", "1", 0}), second(folder.path(), 0, {"7_0", "b", "1", 1});
  first.begun(1);
  second.begun(1);
  first.finished(outcome(1, 2.0));  // two at once: a requeue that the first did not notice
  second.finished(outcome(1, 2.0));
  second.begun(3);
  AttemptReader reader(folder.path());
  EXPECT_THAT(reader.read().outcomes, SizeIs(2)) << "whoever takes them counts the first";
  EXPECT_THAT(reader.broken_off(), ElementsAre(Pair(3, 0)));
  EXPECT_TRUE(std::filesystem::exists(folder / "shard-0.attempt-1.jsonl"));
}

TEST(Attempts, ATornLineIsNoneAndGarbageIsNamed) {
  const testing::ScratchFolder folder;
  const auto file = folder.path() / "shard-0.attempt-0.jsonl";
  const std::string whole = outcome_line(outcome(5, 1.0));
  std::ofstream(file) << whole << "\n" << whole.substr(0, 20);
  AttemptReader reader(folder.path());
  AttemptNews news = reader.read();
  EXPECT_THAT(news.outcomes, SizeIs(1));
  EXPECT_THAT(news.warnings, IsEmpty());
  std::ofstream(file, std::ios::app) << whole.substr(20);
  EXPECT_THAT(reader.read().outcomes, IsEmpty()) << "a line ends with its end";
  std::ofstream(file, std::ios::app) << "\n" << std::string(8, '\0') << "\n[1]\n{}\n" << whole << "\n";
  news = reader.read();
  EXPECT_THAT(news.outcomes, SizeIs(2));
  EXPECT_THAT(news.warnings, ElementsAre(HasSubstr(file.string() + ":3: is no line"), HasSubstr(":4: is no"),
                                         HasSubstr(":5: is no")));
}

TEST(Attempts, KeepTheGateWarningsOfAPoint) {
  const testing::ScratchFolder folder;
  PointOutcome told = outcome(1, 2.0);
  told.gate_warnings = {"ball: few points", "wall: few points"};
  AttemptLog(folder.path(), 0, {"7_0", "a", "1", 0}).finished(told);
  // A log of an earlier version has none.
  folder.write("shard-1.attempt-0.jsonl",
               R"({"id": 2, "failed": false, "reason": "", "numbers": {}, "seconds": 1, "traced": true})"
               "\n");
  const AttemptNews news = AttemptReader(folder.path()).read();
  ASSERT_THAT(news.outcomes, SizeIs(2));
  for (const PointOutcome& o : news.outcomes)
    EXPECT_EQ(o.gate_warnings, o.id == 1 ? told.gate_warnings : std::vector<std::string>());
}

TEST(Attempts, OfStrangersAreLeftOut) {
  const testing::ScratchFolder folder;
  std::string lines =
      R"({"unfit": "all is well", "code": 0})"
      "\n"
      R"({"id": 1, "failed": false, "reason": "", "numbers": {"r": 1e999}, "seconds": 1, "traced": true})"
      "\n";
  lines +=
      "{\"begun\": 3.5e38}\n{\"attempt\": \"1\", \"host\": \"\", \"version\": \"\", \"restart\": 1e99}\n";
  lines += "{\"warning\": " + std::string(100'000, '[') + "\n";
  for (int i = 0; i < 1000; ++i) lines += "[[[\n";
  folder.write("shard-0.attempt-0.jsonl", lines);
  const AttemptNews news = AttemptReader(folder.path()).read();
  EXPECT_FALSE(news.unfit) << "no failure has exit code 0";
  EXPECT_THAT(news.outcomes, IsEmpty());
  EXPECT_THAT(news.warnings, SizeIs(50));
}

// A share that is away for a moment: what stands in for it cannot be read.
TEST(Attempts, AFileThatCannotBeReadIsLookedAtAgain) {
  const testing::ScratchFolder folder;
  const auto away = folder / "shard-0.attempt-0.jsonl", kept = folder / "kept";
  {
    AttemptLog log(folder.path(), 0, {"12_0", "node7", "1.0", 0});
    log.finished({3, false, "", {{"r", 1.0}}, 0.5, true});
  }
  AttemptLog(folder.path(), 1, {"12_1", "node7", "1.0", 0}).finished({4, false, "", {{"r", 1.0}}, 0.5, true});
  AttemptReader reader(folder.path());
  std::filesystem::rename(away, kept);
  ASSERT_EQ(::mkfifo(away.c_str(), 0600), 0);
  const AttemptNews first = reader.read(), second = reader.read();
  EXPECT_THAT(
      first.warnings,
      ElementsAre(::testing::EndsWith(
          "shard-0.attempt-0.jsonl: is a pipe or a device, the log of an attempt must be a regular file")));
  EXPECT_EQ(second.warnings, first.warnings) << "the same words, which are said once";
  EXPECT_THAT(first.outcomes, SizeIs(1)) << "of the task whose log can be read";
  EXPECT_THAT(second.outcomes, IsEmpty());
  std::filesystem::rename(kept, away);
  const AttemptNews third = reader.read();
  EXPECT_THAT(third.warnings, IsEmpty());
  ASSERT_THAT(third.outcomes, SizeIs(1));
  EXPECT_EQ(third.outcomes[0].id, 3);
}

TEST(Rounds, FilesOfStrangersAreRefusedByName) {
  const testing::ScratchFolder folder;
  const auto said = [&] {
    try {
      SlurmRound::read(folder.path());
      return std::string("nothing");
    } catch (const UserError& e) {
      return std::string(e.what());
    }
  };
  folder.write("round.json", std::string(100'000, '['));
  EXPECT_THAT(said(), AllOf(HasSubstr("round.json"), HasSubstr("more than 64 deep")));
  folder.write("round.json",
               R"({"schema": "fringetwin-slurm-round/1", "job_name": "fringetwin-0", "version": "1.0"})");
  EXPECT_EQ(said(), "nothing");
  folder.write("ended.json", "{\"tasks\": " + std::string(100'000, '['));
  EXPECT_THAT(said(), AllOf(HasSubstr("ended.json"), HasSubstr("more than 64 deep")));
}

TEST(Rounds, LastWordsAreThoseOfAnyLog) {
  const testing::ScratchFolder folder;
  const SlurmRound round{folder.path(), "j", "1.0"};
  folder.write("task-0.log", std::string(1'000'000, 'x') + "\nkilled\n\n");
  EXPECT_EQ(round.last_words(0), "killed");
  EXPECT_EQ(round.last_words(1), "");
  ASSERT_EQ(::mkfifo((folder / "task-2.log").c_str(), 0600), 0);
  EXPECT_EQ(round.last_words(2), "");
}

TEST(Rounds, BlameAPointForTheEndOfItsTask) {
  const testing::ScratchFolder folder;
  const auto shards = cut_shards(groups_of({2, 2}), 2);
  for (int round = 0; round < 3; ++round) {
    SlurmBatch batch(folder.path());
    ASSERT_TRUE(batch.begin_round({{"/twin.toml", {}}, ""}, shards, "1.0"));
    SlurmRound& last = *batch.last();
    EXPECT_EQ(last.folder.filename().string(), fmt::format("round-{}", round));
    AttemptLog log(last.folder, 1, {"7_1", "a", "1.0", 0});
    log.begun(2);
    std::ofstream(last.folder / "task-1.log") << "first\nslurmstepd: oom\n\n";
    last.end(round == 1, {{0, "COMPLETED (None)"}, {1, "OUT_OF_MEMORY (OutOfMemory)"}});  // 1: Ctrl-C
    EXPECT_EQ(last.fate(), "1 task OUT_OF_MEMORY (OutOfMemory); the log of task 1 ends: slurmstepd: oom");
  }
  SlurmBatch batch(folder.path());
  EXPECT_TRUE(batch.last()->ended);
  EXPECT_FALSE(batch.last()->cancelled);
  EXPECT_THAT(batch.read().outcomes, IsEmpty());
  const auto deaths = batch.deaths();
  ASSERT_THAT(deaths, SizeIs(1));
  EXPECT_EQ(deaths.at(2).times, 2);
  EXPECT_FALSE(deaths.at(2).alone);
  EXPECT_EQ(deaths.at(2).last, "its task ended OUT_OF_MEMORY (OutOfMemory); its log ends: slurmstepd: oom");
}

TEST(Rounds, BlameNoPointForWhatItCannotCause) {
  const testing::ScratchFolder folder;
  const auto shards = cut_shards(groups_of({1, 1, 1, 1, 1, 1}), 6);
  SlurmBatch batch(folder.path());
  ASSERT_TRUE(batch.begin_round({{"/twin.toml", {}}, ""}, shards, "1.0"));
  for (std::size_t i = 0; i < shards.size(); ++i)
    AttemptLog(batch.last()->folder, i, {"7", "a", "1.0", 0}).begun(shards[i][0].point.id);
  batch.last()->end(false, {{0, "NODE_FAIL (None)"},
                            {1, "PREEMPTED (None)"},
                            {2, "CANCELLED (None)"},
                            {3, "GONE (its end was not seen)"},
                            {4, "TIMEOUT (TimeLimit)"}});
  batch.read();
  const auto deaths = batch.deaths();
  ASSERT_THAT(deaths, SizeIs(1));
  EXPECT_EQ(deaths.begin()->first, shards[4][0].point.id);
  EXPECT_TRUE(deaths.begin()->second.alone);
}

TEST(Rounds, SingleOutThoseThatDiedMostOften) {
  const SlurmBatch::Deaths deaths{{0, {1}}, {1, {2}}, {2, {1}}, {3, {2}}, {99, {9}}};
  const Points points = groups_of({5});
  EXPECT_THAT(most_often_dead(deaths, points, 3), ElementsAre(0, 1, 3)) << "99 is not left";
  EXPECT_THAT(most_often_dead(deaths, points, 64), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(most_often_dead({}, points, 64), IsEmpty());
}

TEST(Rounds, OfWrongTypesAreDamaged) {
  const testing::ScratchFolder folder;
  const auto expect_damaged = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    try {
      SlurmRound::read(folder.path());
      FAIL() << text;
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      EXPECT_THAT(e.what(), HasSubstr(name + ": is damaged")) << text;
    }
  };
  const std::string schema = R"({"schema": "fringetwin-slurm-round/1", )";
  for (const char* text : {"", "[]", "7", R"({"schema": 1})"}) expect_damaged("round.json", text);
  expect_damaged("round.json", schema + R"("job_name": 1, "version": "1.0"})");
  expect_damaged("round.json", schema + R"("job_name": "j"})");
  std::ofstream(folder / "round.json") << schema << R"("job_name": "fringetwin-1,thesis", "version": "1.0"})";
  EXPECT_THROW(SlurmRound::read(folder.path()), UserError) << "nobody else's jobs";
  std::ofstream(folder / "round.json") << schema << R"("job_name": "j", "version": "1.0"})";
  for (const char* text : {"{", "[]", R"({"cancelled": "no"})", R"({"tasks": {"one": "FAILED"}})",
                           R"({"tasks": {"0": 1}})", R"({"tasks": 1})", R"({"tasks": {"-1": "FAILED"}})"})
    expect_damaged("ended.json", text);
  std::ofstream(folder / "ended.json") << R"({"cancelled": true, "tasks": {"0": "FAILED"}})";
  const SlurmRound round = SlurmRound::read(folder.path());
  EXPECT_TRUE(round.ended && round.cancelled);
  EXPECT_EQ(round.states.at(0), "FAILED");
}

TEST(Rounds, OfTwoProcessesOneIsFirst) {
  const testing::ScratchFolder folder;
  const auto shards = cut_shards(groups_of({2}), 1);
  SlurmBatch one(folder.path()), other(folder.path());
  EXPECT_TRUE(one.begin_round({{"/twin.toml", {}}, ""}, shards, "1.0"));
  EXPECT_FALSE(other.begin_round({{"/twin.toml", {}}, ""}, shards, "1.0"));
  EXPECT_EQ(other.last()->job_name, one.last()->job_name);
  one.drop_round();
  EXPECT_EQ(one.last(), nullptr);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

/// A squeue in PATH that says what a file says, and fails where there is none.
class SaidBySqueue {
 public:
  SaidBySqueue() {
    const auto program = folder_ / "squeue";
    std::ofstream(program) << fmt::format("#!/bin/sh\nexec /bin/cat '{}'\n", (folder_ / "said").string());
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~SaidBySqueue() { setenv("PATH", path_.c_str(), 1); }
  void operator=(const std::string& text) { std::ofstream(folder_ / "said") << text; }
  void fails() { std::filesystem::remove(folder_ / "said"); }

 private:
  testing::ScratchFolder folder_;
  std::string path_ = std::getenv("PATH");
};

TEST(Slurm, OneEmptyAnswerIsNoEndOfAJob) {
  SaidBySqueue squeue;
  slurm::Watch watch;
  watch.begin("ours", "7");
  squeue = "7|0|RUNNING|None\n7|1|COMPLETED|None\n";
  watch.ask("ours");
  EXPECT_TRUE(watch.answered() && watch.job().alive());
  squeue = "";
  watch.ask("ours");
  EXPECT_FALSE(watch.answered());
  EXPECT_TRUE(watch.job().alive());
  squeue.fails();
  watch.ask("ours");
  squeue = "";
  watch.ask("ours");
  EXPECT_TRUE(watch.job().alive()) << "not in a row";
  squeue = "7|0|RUNNING|None\n7|1|COMPLETED|None\n";
  watch.ask("ours");
  EXPECT_TRUE(watch.answered());
  squeue = "";
  for (int i = 0; i < 2; ++i) watch.ask("ours");
  EXPECT_TRUE(watch.answered());
  EXPECT_FALSE(watch.job().alive());
  EXPECT_THAT(watch.states(),
              ElementsAre(Pair(0, "GONE (its end was not seen)"), Pair(1, "COMPLETED (None)")));
  watch.ask("another");  // taken up by a command that knows nothing of it
  EXPECT_FALSE(watch.answered());
  watch.ask("another");
  EXPECT_TRUE(watch.answered());
}

TEST(Slurm, OwnOptionsAreKnownInEachForm) {
  for (const char* word : {"--array", "--array=0-3", "--arr=1", "-a", "-a0-3", "--job-name=x", "-Jname",
                           "-D/x", "--chdir=/x", "--output=x", "-ox", "-o", "--out=x", "--error=x", "-ex",
                           "--open-mode=a", "--no-requeue", "--wrap=ls"})
    EXPECT_NE(slurm::own_option(word), "") << word;
  EXPECT_EQ(slurm::own_option("-Jname"), "-J");
  EXPECT_EQ(slurm::own_option("--job=x"), "--job-name");
  for (const char* word :
       {"--partition=long", "-pa", "long", "--exclude=n1", "--export=ALL", "--oversubscribe", "--requeue",
        "--nodelist=n1", "-A", "-c8", "--account=a", "--wait-all-nodes=1", "--", "=--array", "array"})
    EXPECT_EQ(slurm::own_option(word), "") << word;
}

TEST(Slurm, MemoryIsDeclaredByAnyOfItsOptions) {
  for (const char* word : {"--mem", "--mem=4G", "--mem-per-cpu=1G", "--mem-per-gpu=1G"})
    EXPECT_TRUE(slurm::declares_memory({"--time=3", word})) << word;
  EXPECT_FALSE(slurm::declares_memory({"--mem-bind=local", "--cpus-per-task=8"}));
  for (const char* variable : {"SBATCH_MEM_PER_CPU", "SBATCH_MEM_PER_GPU", "SBATCH_MEM_PER_NODE"}) {
    setenv(variable, "1G", 1);
    EXPECT_TRUE(slurm::declares_memory({})) << variable;
    unsetenv(variable);
  }
}

TEST(Slurm, AWordForAShellIsOneWhateverIsInIt) {
  const std::string word = "it's $HOME \"a\" `b` \\ *";
  EXPECT_EQ(testing::run("printf %s " + report::shell_command({word})).output, word);
}

}  // namespace
}  // namespace fringetwin::testing::shard_test
