// SPDX-License-Identifier: Apache-2.0
#include "study/store/study_store.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "study/store/sqlite.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/time_and_host.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {
using Json = nlohmann::json;

constexpr std::int64_t kApplicationId = 0x46545354;  // "FTST", at byte 68 of the file
constexpr std::int64_t kUserVersion = 1;
constexpr const char* kSchema = "fringetwin-study-store/1";

constexpr const char* kTables = R"(
CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE points(
  id INTEGER PRIMARY KEY, settings TEXT NOT NULL, seed INTEGER NOT NULL,
  status TEXT NOT NULL CHECK(status IN ('pending', 'done', 'failed')) DEFAULT 'pending',
  reason TEXT NOT NULL DEFAULT '', results TEXT, seconds REAL, traced INTEGER,
  version TEXT, host TEXT, finished_at TEXT);
CREATE INDEX points_by_status ON points(status);)";

PointStatus status_of(const std::string& name) {
  return name == "done" ? PointStatus::done : name == "failed" ? PointStatus::failed : PointStatus::pending;
}

}  // namespace

struct StudyStore::Impl {
  explicit Impl(const fs::path& file) : database(file) {}
  Database database;
  std::string version, host;
};

namespace {

std::string meta(const Database& database, const char* key) {
  Statement statement(database, "SELECT value FROM meta WHERE key = ?1");
  return statement.bind(1, std::string(key)).step() ? statement.text(0) : "";
}

/// Returns true for a store, false for a file with nothing in it yet.
bool is_store(const Database& database) {
  // In this order: another process may make the tables and the id, in one transaction, between the two.
  const bool empty = database.integer("SELECT count(*) FROM sqlite_master") == 0;
  const std::int64_t application = database.integer("PRAGMA application_id");
  if (application == 0 && empty) return false;
  if (application != kApplicationId)
    database.refuse("is the database of another program", "give another --out");
  if (const std::int64_t version = database.integer("PRAGMA user_version"); version != kUserVersion)
    database.refuse(
        fmt::format("is a study's file of version {}, this program reads {}", version, kUserVersion),
        "use the program that made it, or give another --out");
  return true;
}

void make_tables(const Database& database, const StudyIdentity& identity, const std::string& version) {
  database.run(kTables);
  const std::pair<const char*, std::string> values[] = {
      {"schema", kSchema},           {"study", identity.study},
      {"digest", identity.digest()}, {"inputs", Json(identity.inputs).dump()},
      {"version", version},          {"created_at", utc_now()}};
  Statement insert(database, "INSERT INTO meta(key, value) VALUES(?1, ?2)");
  for (const auto& [key, value] : values) insert.bind(1, std::string(key)).bind(2, value).run();
  database.run(
      fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kUserVersion));
}

/// Returns the first difference, for the sentence about another study.
void check_identity(const Database& database, const StudyIdentity& identity) {
  if (meta(database, "digest") == identity.digest()) return;
  constexpr const char* kHint = "give another --out: its results stay as they are";
  if (meta(database, "study") != identity.study) database.refuse("holds another study", kHint);
  const Json inputs = Json::parse(meta(database, "inputs"), nullptr, false);
  for (const auto& [name, sha256] : identity.inputs)
    if (inputs.is_object() && inputs.contains(name) && inputs[name] != sha256)
      database.refuse(fmt::format("holds results of another {}", name),
                      "the file has changed since; give another --out");
  database.refuse("holds results of other input files", kHint);
}

}  // namespace

StudyStore::StudyStore(const fs::path& file, const StudyIdentity& identity, const std::string& version)
    : impl_(std::make_unique<Impl>(file)) {
  impl_->version = version;
  impl_->host = host_name();
  is_store(impl_->database);  // before anything is written to what may be another's
  impl_->database.use_write_ahead_log();
  if (!is_store(impl_->database)) {
    Transaction transaction(impl_->database);
    if (!is_store(impl_->database))
      make_tables(impl_->database, identity, version);  // another process may have been first
    transaction.commit();
  }
  check_identity(impl_->database, identity);
}

StudyStore::~StudyStore() = default;

std::string StudyStore::digest() const { return meta(impl_->database, "digest"); }

void StudyStore::add(const std::vector<StudyPoint>& points) {
  Transaction transaction(impl_->database);
  Statement insert(impl_->database, "INSERT OR IGNORE INTO points(id, settings, seed) VALUES(?1, ?2, ?3)");
  for (const StudyPoint& point : points)
    insert.bind(1, point.id)
        .bind(2, Json(point.settings).dump())
        .bind(3, static_cast<std::int64_t>(point.seed))
        .run();
  transaction.commit();
}

void StudyStore::record(const std::vector<PointOutcome>& outcomes) {
  Transaction transaction(impl_->database);
  Statement update(impl_->database,
                   "UPDATE points SET status = ?2, reason = ?3, results = ?4, seconds = ?5, traced = ?6, "
                   "version = ?7, host = ?8, finished_at = ?9 WHERE id = ?1 AND status = 'pending'");
  for (const PointOutcome& outcome : outcomes)
    update.bind(1, outcome.id)
        .bind(2, std::string(outcome.failed ? "failed" : "done"))
        .bind(3, outcome.reason)
        .bind(4, Json(outcome.numbers).dump())  // what is not finite becomes null
        .bind(5, outcome.seconds)
        .bind(6, std::int64_t{outcome.traced ? 1 : 0})
        .bind(7, outcome.version.empty() ? impl_->version : outcome.version)
        .bind(8, outcome.host.empty() ? impl_->host : outcome.host)
        .bind(9, utc_now())
        .run();
  transaction.commit();
}

std::vector<StoredPoint> StudyStore::rows(std::int64_t first_id, std::int64_t last_id) const {
  Statement select(impl_->database,
                   "SELECT id, settings, seed, status, reason, results, seconds, traced, version, host, "
                   "finished_at FROM points WHERE id BETWEEN ?1 AND ?2 ORDER BY id");
  select.bind(1, first_id).bind(2, last_id);
  std::vector<StoredPoint> rows;
  while (select.step()) {
    StoredPoint row;
    const Json settings = Json::parse(select.text(1), nullptr, false);
    if (!settings.is_object())
      impl_->database.refuse(fmt::format("is damaged (row {})", select.integer(0)), "");
    row.point = {select.integer(0), settings.get<Settings>(), static_cast<std::uint64_t>(select.integer(2))};
    row.status = status_of(select.text(3));
    row.outcome.id = row.point.id;
    row.outcome.failed = row.status == PointStatus::failed;
    row.outcome.reason = select.text(4);
    if (row.status != PointStatus::pending) {
      const Json results = Json::parse(select.text(5), nullptr, false);
      if (!results.is_object()) impl_->database.refuse(fmt::format("is damaged (row {})", row.point.id), "");
      for (const auto& [name, value] : results.items())
        row.outcome.numbers[name] = value.is_number() ? value.get<double>() : kNaN;
      row.outcome.seconds = select.real(6);
      row.outcome.traced = select.integer(7) != 0;
    }
    row.version = select.text(8);
    row.host = select.text(9);
    row.finished_at = select.text(10);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<StudyPoint> StudyStore::pending() const {
  std::vector<StudyPoint> points;
  for (StoredPoint& row : rows())
    if (row.status == PointStatus::pending) points.push_back(std::move(row.point));
  return points;
}

StudyStore::Counts StudyStore::counts() const {
  Counts counts;
  Statement select(impl_->database, "SELECT status, count(*) FROM points GROUP BY status");
  while (select.step()) {
    const PointStatus status = status_of(select.text(0));
    (status == PointStatus::done     ? counts.done
     : status == PointStatus::failed ? counts.failed
                                     : counts.pending) = select.integer(1);
  }
  return counts;
}

}  // namespace fringetwin::study
