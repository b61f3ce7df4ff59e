// SPDX-License-Identifier: Apache-2.0
// What is stored stays stored, and a file that is no store of this study is left alone.
#include "study/store/study_store.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <thread>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::study_store_test {
namespace {
using namespace fringetwin::study;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const StudyIdentity kIdentity{"design = grid\n", {{"/rig/twin.toml", "aa"}, {"/rig/part.stl", "bb"}}};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<StudyPoint> some_points(std::int64_t n) {
  std::vector<StudyPoint> points;
  for (std::int64_t i = 0; i < n; ++i)
    points.push_back({i, {{"camera.left.sensor.bit_depth", std::to_string(8 + i % 9)}}, std::uint64_t(i)});
  return points;
}
PointOutcome outcome(std::int64_t id, double radius_mm) {
  return {id, false, "", {{"radius_mm", radius_mm}, {"rms_mm", 0.1 * radius_mm}}, 0.5, true};
}
/// Of the points, the id as the radius.
std::vector<PointOutcome> outcomes(const std::vector<StudyPoint>& points) {
  std::vector<PointOutcome> all;
  for (const StudyPoint& point : points) all.push_back(outcome(point.id, static_cast<double>(point.id)));
  return all;
}

class StudyStoreTest : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return folder_ / "study.db"; }
  StudyStore open() const { return StudyStore(file(), kIdentity, "1.0"); }
  /// The sentence about the file.
  std::string error(const std::function<void()>& work, ExitCode code = ExitCode::usage) const {
    try {
      work();
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), code);
      return e.what();
    }
    ADD_FAILURE() << "no UserError";
    return "";
  }
  std::string open_error(const std::filesystem::path& path, const StudyIdentity& identity = kIdentity,
                         ExitCode code = ExitCode::usage) const {
    const std::string message = error([&] { StudyStore(path, identity, "1.0"); }, code);
    EXPECT_THAT(message, HasSubstr(path.string() + ": "));
    return message;
  }
  /// By SQLite itself, not by our code.
  void sql(const std::filesystem::path& path, const char* text) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, text, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
  }
  testing::ScratchFolder folder_;
};

/// Runs `work` in a process of its own; gives its id.
pid_t in_child(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    int status = 1;
    try {
      work();
      status = 0;
    } catch (const std::exception& e) {
      fmt::print(stderr, "{}\n", e.what());
    }
    ::_exit(status);
  }
  return child;
}
int end_of(pid_t child) {
  int status = -1;
  ::waitpid(child, &status, 0);
  return status;
}

TEST_F(StudyStoreTest, RowsComeBackAsTheyWent) {
  const double odd = 0.1 + 0.2, tiny = 4.9e-324;
  {
    StudyStore store = open();
    store.add(some_points(3));
    store.record({{1, false, "", {{"a b", odd}, {"n", kNaN}, {"tiny", tiny}}, 1.5, false},
                  {0, true, "the sphere \"ball\", unseen", {}, 0.25, true, "node7", "0.9"}});
  }
  const auto rows = open().rows();
  ASSERT_THAT(rows, SizeIs(3));
  EXPECT_EQ(rows[0].status, PointStatus::failed);
  EXPECT_TRUE(rows[0].outcome.failed);
  EXPECT_EQ(rows[0].outcome.reason, "the sphere \"ball\", unseen");
  EXPECT_EQ(rows[0].host, "node7") << "another machine of the cluster";
  EXPECT_EQ(rows[0].version, "0.9");
  EXPECT_EQ(rows[1].status, PointStatus::done);
  EXPECT_EQ(rows[1].point.settings, some_points(3)[1].settings);
  EXPECT_EQ(rows[1].point.seed, 1u);
  EXPECT_EQ(rows[1].outcome.numbers.at("a b"), odd);
  EXPECT_EQ(rows[1].outcome.numbers.at("tiny"), tiny);
  EXPECT_TRUE(std::isnan(rows[1].outcome.numbers.at("n")));
  EXPECT_EQ(rows[1].outcome.seconds, 1.5);
  EXPECT_FALSE(rows[1].outcome.traced);
  EXPECT_EQ(rows[1].version, "1.0");
  EXPECT_FALSE(rows[1].host.empty());
  EXPECT_THAT(rows[1].finished_at, ::testing::MatchesRegex("20..-..-..T..:..:..Z"));
  EXPECT_EQ(rows[2].status, PointStatus::pending);
  EXPECT_EQ(rows[2].finished_at, "");
}

TEST_F(StudyStoreTest, AFinishedPointStaysAsItIs) {
  StudyStore store = open();
  store.add(some_points(3));
  store.record({outcome(1, 5.0)});
  store.add(some_points(5));
  store.record({outcome(1, 6.0)});
  store.record({});
  ASSERT_THAT(store.pending(), SizeIs(4));
  EXPECT_EQ(store.pending()[1].id, 2);
  EXPECT_EQ(store.rows()[1].outcome.numbers.at("radius_mm"), 5.0);
  const auto counts = store.counts();
  EXPECT_EQ(counts.pending, 4);
  EXPECT_EQ(counts.done, 1);
  EXPECT_EQ(counts.failed, 0);
}

TEST_F(StudyStoreTest, AnotherStudyIsRefused) {
  {
    StudyStore store = open();
    store.add(some_points(1));
  }
  StudyIdentity other = kIdentity;
  other.study += "seed = 2\n";
  EXPECT_THAT(open_error(file(), other), HasSubstr("holds another study"));
  other = kIdentity;
  other.inputs["/rig/part.stl"] = "cc";
  EXPECT_THAT(open_error(file(), other), HasSubstr("holds results of another /rig/part.stl"));
  other = kIdentity;
  other.inputs["/rig/more.stl"] = "cc";
  EXPECT_THAT(open_error(file(), other), HasSubstr("other input files"));
  other = {kIdentity.study, {{"/moved/twin.toml", "aa"}, {"/moved/part.stl", "bb"}}};
  EXPECT_THAT(StudyStore(file(), other, "1.0").rows(), SizeIs(1)) << "the same files elsewhere";
}

TEST_F(StudyStoreTest, ForeignFilesStayAsTheyAre) {
  const auto unchanged = [&](const std::string& name, const std::string& said,
                             ExitCode code = ExitCode::usage) {
    const std::string before = testing::read_file(folder_ / name);
    EXPECT_THAT(open_error(folder_ / name, kIdentity, code), HasSubstr(said));
    EXPECT_EQ(testing::read_file(folder_ / name), before) << name;
  };
  folder_.write("text.db", std::string(5000, 'x'));
  unchanged("text.db", "is no SQLite database", ExitCode::input);
  sql(folder_ / "other.db", "CREATE TABLE t(x); INSERT INTO t VALUES(1)");
  unchanged("other.db", "is the database of another program");
  sql(folder_ / "id.db", "PRAGMA application_id = 7");
  unchanged("id.db", "is the database of another program");
  sql(folder_ / "new.db", "PRAGMA application_id = 1179931476; PRAGMA user_version = 3");  // "FTST"
  unchanged("new.db", "is a study's file of version 3");
  sql(folder_ / "view.db",
      "CREATE VIEW points AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id FROM n) SELECT id FROM n;"
      "PRAGMA application_id = 1179931476; PRAGMA user_version = 2");
  unchanged("view.db", "has other tables than the database of a study", ExitCode::input);
}

TEST_F(StudyStoreTest, DamagedFilesAreRefused) {
  {
    StudyStore store = open();
    store.add(some_points(2000));
  }
  std::string bytes = testing::read_file(file());
  ASSERT_GT(bytes.size(), 20'000u);
  folder_.write("short.db", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(error([&] { StudyStore(folder_ / "short.db", kIdentity, "1.0").rows(); }, ExitCode::input),
              HasSubstr("is damaged"));
  for (std::size_t i = 4096; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7);
  folder_.write("torn.db", bytes);
  EXPECT_THAT(error([&] { StudyStore(folder_ / "torn.db", kIdentity, "1.0").rows(); }, ExitCode::input),
              HasSubstr("is damaged"));
}

/// What a run of the study with these points does with the file, but for the work.
std::string csv_of_run(const std::filesystem::path& file, const std::vector<StudyPoint>& points) {
  StudyStore store(file, kIdentity, "1.0");
  store.refuse_rows_from(static_cast<std::int64_t>(points.size()));
  store.add(points);
  store.record(outcomes(store.pending()));
  return study_csv(store.finished_rows());
}

TEST_F(StudyStoreTest, RowsThatAreNotOfTheStudyAreRefused) {
  const std::vector<StudyPoint> points = some_points(3);
  csv_of_run(file(), points);
  const std::string good = testing::read_file(file());
  const StudyIdentity another{"design = list\n", {}};
  {
    StudyStore store(folder_ / "other.db", another, "1.0");
    store.add(points);
    store.record(outcomes(points));
  }
  const std::string take_another =
      "ATTACH '" + (folder_ / "other.db").string() +
      "' AS other; UPDATE points SET (results, digest) = (SELECT results, digest "
      "FROM other.points o WHERE o.id = points.id)";
  const std::pair<const char*, const char*> cases[] = {
      {"INSERT INTO points(id, settings, seed) VALUES(7, '{}', 7)",
       "row 7 is none of the study's points 0 ... 2"},
      {"INSERT INTO points(id, settings, seed) VALUES(-1, '{}', 7)", "row -1 is none"},
      {"UPDATE points SET settings = '{}' WHERE id = 1", "row 1 is another point"},
      {"UPDATE points SET settings = '[1' WHERE id = 1", "row 1 is another point"},
      {"UPDATE points SET settings = '{\"a\": 1}' WHERE id = 1", "row 1 is another point"},
      {"UPDATE points SET settings = CAST(settings AS BLOB)", "row 0 is another point"},
      {"UPDATE points SET seed = 9 WHERE id = 2", "row 2 is another point"},
      {"UPDATE points SET results = '{\"radius_mm\": 2}' WHERE id = 1", "row 1 is damaged"},
      {"UPDATE points SET results = NULL WHERE id = 1", "row 1 is damaged"},
      {"UPDATE points SET reason = 'dark' WHERE id = 0", "row 0 is damaged"},
      {"UPDATE points SET status = 'failed' WHERE id = 1", "row 1 is damaged"},
      {"PRAGMA ignore_check_constraints = ON; UPDATE points SET status = 'lost' WHERE id = 1",
       "row 1 is damaged"},
      {"UPDATE points SET digest = '' WHERE id = 1", "row 1 is damaged"},
      {take_another.c_str(), "row 0 is damaged"},
      {"CREATE TRIGGER t AFTER UPDATE ON points BEGIN DELETE FROM points; END", "has other tables"},
      {"ALTER TABLE points ADD COLUMN more TEXT", "has other tables"}};
  for (const auto& [change, said] : cases) {
    folder_.write("changed.db", good);
    sql(folder_ / "changed.db", change);
    EXPECT_THAT(error([&] { csv_of_run(folder_ / "changed.db", points); }, ExitCode::input), HasSubstr(said))
        << change;
  }
  folder_.write("less.db", good);
  sql(folder_ / "less.db", "DELETE FROM points WHERE id = 1");
  EXPECT_EQ(csv_of_run(folder_ / "less.db", points), csv_of_run(file(), points))
      << "what is lost is run again";
  EXPECT_THAT(error([&] { StudyStore(file(), kIdentity, "1.0").finished_rows(); }, ExitCode::input),
              HasSubstr("has other rows than the 0 of this study"));
}

TEST_F(StudyStoreTest, AUsersOwnMayBeLarge) {
  const std::vector<StudyPoint> points = some_points(3);
  const std::string table = csv_of_run(file(), points);
  std::filesystem::resize_file(file(), std::uintmax_t{3} << 30);  // sparse; what SQLite's header counts stays
  EXPECT_EQ(csv_of_run(file(), points), table);
  std::filesystem::resize_file(file(), std::uintmax_t{9} << 30);
  EXPECT_THAT(error([&] { StudyStore(file(), kIdentity, "1.0"); }, ExitCode::usage),
              HasSubstr("--limits 10 reads ten times as much"));
}

// Whatever a failing disk does to a byte, the table is the same or there is none.
TEST_F(StudyStoreTest, NoDamageChangesTheTable) {
  const std::vector<StudyPoint> points = some_points(40);
  const std::string table = csv_of_run(file(), points);
  const std::string good = testing::read_file(file());
  int refused = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    std::string bytes = good;
    bytes[(i * 7919 + 24) % bytes.size()] ^= static_cast<char>(1 << i % 8);
    folder_.write("damaged.db", bytes);
    std::filesystem::remove(folder_ / "damaged.db-wal");
    try {
      EXPECT_EQ(csv_of_run(folder_ / "damaged.db", points), table) << i;
    } catch (const UserError& e) {
      EXPECT_THAT(e.what(), HasSubstr("damaged.db: ")) << i;
      ++refused;
    }
  }
  EXPECT_GT(refused, 5);
}

TEST_F(StudyStoreTest, APipeIsNoDatabase) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe.db").c_str(), 0600), 0);
  EXPECT_THAT(open_error(folder_ / "pipe.db"), HasSubstr("is a pipe or a device"));
}

TEST_F(StudyStoreTest, PlacesThatCannotBeWritten) {
  EXPECT_THAT(open_error(folder_ / "none/study.db"), HasSubstr("cannot be opened"));
  EXPECT_THAT(open_error(folder_.path()), HasSubstr("is a folder"));
  EXPECT_THAT(open_error("/proc/study.db"), HasSubstr("cannot be opened"))
      << "a read-only folder, also for root";
}

// A limit on the size of files stands for a full disk: write() fails, in the middle of the log.
TEST_F(StudyStoreTest, AFullDiskLosesNothingThatWasStored) {
  {
    StudyStore store = open();
    store.add(some_points(4000));
  }
  const auto size = std::filesystem::file_size(file());
  const auto told = folder_ / "told";
  const pid_t child = in_child([&] {
    StudyStore store = open();
    const rlimit limit{size / 2, size / 2};
    std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::int64_t id = 0;
    try {
      for (; id < 4000; ++id) store.record({outcome(id, static_cast<double>(id))});
    } catch (const UserError& e) {
      folder_.write("told", fmt::format("{} {}", id, e.what()));
      if (store.counts().done != id) throw std::runtime_error("reading after the failure");
      return;
    }
    throw std::runtime_error("nothing failed");
  });
  ASSERT_EQ(end_of(child), 0);
  const std::string message = testing::read_file(told);
  EXPECT_THAT(message, AllOf(HasSubstr("study.db: cannot be written"), HasSubstr("if the disk is full"),
                             HasSubstr("what is stored is safe")));
  const auto stored = std::stoll(message);
  EXPECT_GT(stored, 0);
  StudyStore store = open();
  EXPECT_EQ(store.counts().done, stored);
  store.record(outcomes(store.pending()));
  EXPECT_EQ(store.counts().done, 4000);
}

TEST_F(StudyStoreTest, SeveralProcessesMakeAndFillOneStore) {
  constexpr std::int64_t n = 200;
  constexpr int writers = 4;
  for (int round = 0; round < 5; ++round) {
    std::filesystem::remove_all(folder_ / "study.db");
    std::vector<pid_t> children;
    for (int k = 0; k < writers; ++k)
      children.push_back(in_child([&] {
        StudyStore store = open();
        store.add(some_points(n));
        for (std::int64_t id = k % 2; id < n; id += 2) store.record({outcome(id, static_cast<double>(k))});
      }));
    for (const pid_t child : children) EXPECT_EQ(end_of(child), 0);
    const auto rows = open().rows();
    ASSERT_THAT(rows, SizeIs(n));
    for (const StoredPoint& row : rows) {
      ASSERT_EQ(row.status, PointStatus::done);
      // two writers of the same parity race for a point: one of them, as a whole
      const double radius = row.outcome.numbers.at("radius_mm");
      EXPECT_EQ(static_cast<std::int64_t>(radius) % 2, row.point.id % 2);
      EXPECT_EQ(row.outcome.numbers.at("rms_mm"), 0.1 * radius);
    }
  }
}

// Killed at random times between the opening and the last point; what record() had returned for is there.
TEST_F(StudyStoreTest, AKilledProcessLosesNothingThatWasStored) {
  constexpr std::int64_t n = 1000;
  int kills = 0;
  for (int round = 0; round < 100; ++round) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = in_child([&] {
      StudyStore store = open();
      store.add(some_points(n));
      for (const StudyPoint& point : store.pending()) {
        store.record({outcome(point.id, static_cast<double>(point.id))});
        if (::write(pipe[1], &point.id, sizeof point.id) != sizeof point.id) throw std::runtime_error("pipe");
        std::this_thread::sleep_for(std::chrono::microseconds(200));  // else all is over on a fast disk
      }
    });
    ::close(pipe[1]);
    std::this_thread::sleep_for(std::chrono::milliseconds(1 + round * 7 % 40));
    ::kill(child, SIGKILL);
    kills += WIFSIGNALED(end_of(child)) ? 1 : 0;
    std::vector<std::int64_t> acknowledged;
    for (std::int64_t id; ::read(pipe[0], &id, sizeof id) == sizeof id;) acknowledged.push_back(id);
    ::close(pipe[0]);
    const auto rows = open().rows();
    ASSERT_TRUE(rows.empty() || rows.size() == n) << "points are added all or none";
    for (const std::int64_t id : acknowledged)
      ASSERT_EQ(rows[static_cast<std::size_t>(id)].status, PointStatus::done);
    if (!rows.empty() && rows.back().status == PointStatus::done) break;
  }
  EXPECT_GE(kills, 5);
  StudyStore store = open();
  store.add(some_points(n));
  store.record(outcomes(store.pending()));
  std::int64_t id = 0;
  for (const StoredPoint& row : store.rows()) {
    EXPECT_EQ(row.status, PointStatus::done);
    EXPECT_EQ(row.outcome.numbers, outcome(id, static_cast<double>(id)).numbers);
    ++id;
  }
}

TEST(StudyCsv, CellsAndOrder) {
  StoredPoint first{{0, {{"render.sampler", "\"gauss\""}, {"fringes.pitches_px", "[13, 14]"}}, 7},
                    PointStatus::done,
                    {0, false, "", {{"radius_mm", 0.1}, {"rms_mm", kNaN}}, 3.0, true},
                    "1",
                    "here",
                    "now"};
  StoredPoint second{{1, {{"render.sampler", "\"sobol\""}}, 8},
                     PointStatus::failed,
                     {1, true, "no \"fit\"", {}, 1.0, true},
                     "1",
                     "there",
                     "later"};
  StoredPoint third{{2, {}, 9}, PointStatus::pending, {}, "", "", ""};
  EXPECT_EQ(study_csv({first, second, third}),
            "id,fringes.pitches_px,render.sampler,noise_seed,status,reason,radius_mm,rms_mm\r\n"
            "0,\"[13, 14]\",gauss,7,done,,0.1,\r\n"
            "1,,sobol,8,failed,\"no \"\"fit\"\"\",,\r\n"
            "2,,,9,pending,,,\r\n");
}

}  // namespace
}  // namespace fringetwin::testing::study_store_test
