// SPDX-License-Identifier: Apache-2.0
// Worker processes: the same table whatever their number and whatever becomes of them.
// tolerance: none.
#include "study/engine/local_engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <fstream>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::local_engine_test {
namespace {

namespace fs = std::filesystem;
using study::EngineSummary;
using study::LocalOptions;
using study::PointOutcome;
using study::StudyPoint;
using ::testing::HasSubstr;

using Table = std::map<std::int64_t, PointOutcome>;

fs::path twin_file() {
  const auto file = scratch_folder("local_engine") / "twin.toml";
  write_file(file, small_twin());
  return file;
}

/// Radii x seeds, the fourth radius too large to be seen from outside.
std::vector<StudyPoint> points() {
  std::vector<StudyPoint> all;
  for (const char* radius : {"18", "19", "20", "900"})
    for (const std::uint64_t seed : {1U, 2U, 3U})
      all.push_back({static_cast<std::int64_t>(all.size()),
                     {{"object.ball.radius_mm", radius}, {"camera.left.sensor.electrons_per_dn", "40"}},
                     seed});
  return all;
}

LocalOptions options(int jobs) {
  LocalOptions o;
  o.worker = {std::getenv("FRINGETWIN_BINARY"), "study-worker"};
  o.jobs = jobs;
  return o;
}

EngineSummary run(const fs::path& file, const LocalOptions& o, const std::set<std::int64_t>& done,
                  Table* table) {
  return study::LocalEngine(o).run(
      {file, {}}, study::plan_traces(file, points()), done,
      [&](const PointOutcome& p) { EXPECT_TRUE(table->emplace(p.id, p).second) << "twice: " << p.id; });
}

void expect_same(const Table& a, const Table& b) {
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [id, p] : a) {
    const PointOutcome& q = b.at(id);
    EXPECT_EQ(p.failed, q.failed) << q.reason;
    EXPECT_EQ(p.reason, q.reason);
    ASSERT_EQ(p.numbers.size(), q.numbers.size());
    for (const auto& [name, value] : p.numbers)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(q.numbers.at(name)))
          << id << ' ' << name;
  }
}

std::vector<pid_t> workers_of(pid_t parent) {
  std::vector<pid_t> all;
  std::ifstream list("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
  for (pid_t p; list >> p;) all.push_back(p);
  return all;
}

TEST(LocalEngine, TheSameTableWithAnyNumberOfWorkers) {
  FT_NEED_DEVICE();
  const fs::path file = twin_file();
  Table one, three;
  const EngineSummary summary = run(file, options(1), {}, &one);
  EXPECT_EQ(summary.finished, 12U);
  EXPECT_EQ(summary.failed, 3U);
  EXPECT_EQ(summary.traced, 3U) << "three radii; the fourth is refused before the trace is done";
  EXPECT_THAT(one.at(9).reason, HasSubstr("inside the sphere"));
  run(file, options(3), {}, &three);
  expect_same(one, three);
  Table rest;
  run(file, options(2), {0, 1, 2, 5, 7, 9, 10}, &rest);
  EXPECT_EQ(rest.size(), 5U);
  for (auto& [id, p] : rest) three[id] = p;
  expect_same(one, three);
}

TEST(LocalEngine, ACrashIsTheFailureOfItsPointOnly) {
  FT_NEED_DEVICE();
  const fs::path file = twin_file();
  Table whole, table;
  run(file, options(1), {}, &whole);
  const auto plan = study::plan_traces(file, points());
  int kills = 0;
  study::LocalEngine(options(1)).run({file, {}}, plan, {}, [&](const PointOutcome& p) {
    EXPECT_TRUE(table.emplace(p.id, p).second);
    // The worker starts on the next point as soon as this returns; it is gone by then.
    if (p.id == 4 && kills++ == 0)
      for (const pid_t pid : workers_of(getpid())) kill(pid, SIGSEGV);
  });
  ASSERT_EQ(table.size(), whole.size());
  EXPECT_TRUE(table.at(5).failed);
  EXPECT_THAT(table.at(5).reason, HasSubstr("killed by signal 11"));
  table[5] = whole[5];
  expect_same(whole, table);
}

// A session or a cluster tells all processes to go at once: the one that has the study decides.
TEST(LocalEngine, WorkersThatAreToldToGoFinishTheirPoints) {
  FT_NEED_DEVICE();
  const fs::path file = twin_file();
  Table whole, table;
  run(file, options(1), {}, &whole);
  study::LocalEngine(options(1))
      .run({file, {}}, study::plan_traces(file, points()), {}, [&](const PointOutcome& p) {
        EXPECT_TRUE(table.emplace(p.id, p).second);
        for (const int told_to_go : {SIGINT, SIGTERM, SIGHUP})
          for (const pid_t pid : workers_of(getpid())) kill(pid, told_to_go);
      });
  expect_same(whole, table);
}

TEST(LocalEngine, WorkersStayForTheNextPointsOfTheSameTask) {
  FT_NEED_DEVICE();
  const fs::path file = twin_file();
  study::LocalEngine engine(options(2));
  const auto run_points = [&](std::vector<StudyPoint> some, const study::PointTask& task) {
    Table table;
    const auto plan = study::plan_traces(file, some);
    engine.run(task, plan, {}, [&](const PointOutcome& p) { table.emplace(p.id, p); });
    return table;
  };
  const std::vector<StudyPoint> all = points();
  const Table first = run_points({all[0], all[3]}, {file, {}});
  const std::vector<pid_t> workers = workers_of(getpid());
  EXPECT_EQ(workers.size(), 2U);
  const Table second = run_points({all[1], all[4]}, {file, {}});
  EXPECT_EQ(workers_of(getpid()), workers);
  Table fresh;
  run(file, options(1), {}, &fresh);
  expect_same({{1, fresh[1]}, {4, fresh[4]}}, second);
  expect_same({{0, fresh[0]}, {3, fresh[3]}}, first);
  // One that went away meanwhile costs no point.
  kill(workers[0], SIGKILL);
  waitid(P_PID, static_cast<id_t>(workers[0]), nullptr, WEXITED | WNOWAIT);
  expect_same({{2, fresh[2]}, {5, fresh[5]}}, run_points({all[2], all[5]}, {file, {}}));
  run_points({all[0], all[3]}, {file, {{"fits.ball.measured.radius_mm", "r"}}});
  for (const pid_t old : workers)
    EXPECT_FALSE([&] {
      const auto now = workers_of(getpid());
      return std::find(now.begin(), now.end(), old) != now.end();
    }()) << "another task, other workers";
}

TEST(LocalEngine, WithoutADeviceNoPointFails) {
  const fs::path file = twin_file();
  Table table;
  LocalOptions o = options(2);
  o.device = "no such device";
  try {
    run(file, o, {}, &table);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::device) << e.what();
  }
  EXPECT_TRUE(table.empty());
  o.worker = {"/bin/false"};
  EXPECT_THROW(run(file, o, {}, &table), UserError);
  EXPECT_TRUE(table.empty());
}

TEST(LocalEngine, AFaultOfTheStoreEndsTheWorkers) {
  FT_NEED_DEVICE();
  const fs::path file = twin_file();
  const auto plan = study::plan_traces(file, points());
  EXPECT_THROW(study::LocalEngine(options(2))
                   .run({file, {}}, plan, {},
                        [](const PointOutcome&) { throw UserError(ExitCode::input, "study.db", "full"); }),
               UserError);
  EXPECT_TRUE(workers_of(getpid()).empty());
}

}  // namespace
}  // namespace fringetwin::testing::local_engine_test
