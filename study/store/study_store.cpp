// SPDX-License-Identifier: Apache-2.0
#include "study/store/study_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "study/store/sqlite.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/sha256.hpp"
#include "twin/base/time_and_host.hpp"
#include "twin/file/json_values.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {
using Json = nlohmann::json;

constexpr std::int64_t kApplicationId = 0x46545354;  // "FTST", at byte 68 of the file
constexpr std::int64_t kUserVersion = 2;
constexpr const char* kSchema = "fringetwin-study-store/2";

// As SQLite keeps it, statement by statement in the order of their names.
constexpr const char* kTables =
    R"(CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;CREATE TABLE points(
  id INTEGER PRIMARY KEY, settings TEXT NOT NULL, seed INTEGER NOT NULL,
  status TEXT NOT NULL CHECK(status IN ('pending', 'done', 'failed')) DEFAULT 'pending',
  reason TEXT NOT NULL DEFAULT '', results TEXT, seconds REAL, traced INTEGER,
  version TEXT, host TEXT, finished_at TEXT, digest TEXT);CREATE INDEX points_by_status ON points(status))";

PointStatus status_of(const std::string& name) {
  return name == "done" ? PointStatus::done : name == "failed" ? PointStatus::failed : PointStatus::pending;
}

/// What a row says of a finished point.
struct Finish {
  std::int64_t id;
  std::string status, reason, results;
  double seconds;
  std::int64_t traced;
  std::string version, host, finished_at;

  /// Returns what a row has that was written for this study and not changed since: 64 bits, so that damage
  /// does not meet them by chance.
  std::string digest(const std::string& study) const {
    constexpr std::size_t kDigits = 16;
    return sha256_of_text(fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}", study, id, status, reason,
                                      results, seconds, traced, version, host, finished_at))
        .substr(0, kDigits);
  }
  /// Throws Json::exception and std::out_of_range.
  PointOutcome outcome() const {
    PointOutcome out{.id = id, .failed = status == "failed", .reason = reason};
    const auto numbers = parse_json<Json>(results);
    for (const auto& [name, value] : numbers.get_ref<const Json::object_t&>())
      out.numbers[name] = value.is_null() ? kNaN : value.get<double>();
    out.seconds = seconds;
    out.traced = traced != 0;
    return out;
  }
};

}  // namespace

struct StudyStore::Impl {
  explicit Impl(const fs::path& file) : database(file) {}
  Database database;
  std::string version, host, digest;
  std::set<std::int64_t> ids;  ///< of the points that were added
};

namespace {

std::string meta(const Database& database, const char* key) {
  Statement statement(database, "SELECT value FROM meta WHERE key = ?1");
  return statement.bind(1, std::string(key)).step() ? statement.text(0) : "";
}

/// A view or a trigger of a stranger would run with every statement, perhaps for ever.
void check_tables(const Database& database) {
  Statement tables(database, "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY name");
  std::string all;
  while (tables.step()) all += (all.empty() ? "" : ";") + tables.text(0);
  if (all != kTables) database.refuse_damage("has other tables than the database of a study");
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
  check_tables(database);
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
  const std::string kept = meta(database, "inputs");
  const Json inputs = json_excess(kept).empty() ? Json::parse(kept, nullptr, false) : Json();
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
  impl_->digest = identity.digest();
}

StudyStore::~StudyStore() = default;

std::string StudyStore::digest() const { return impl_->digest; }

void StudyStore::add(const PointSequence& points) {
  Transaction transaction(impl_->database);
  Statement insert(impl_->database, "INSERT OR IGNORE INTO points(id, settings, seed) VALUES(?1, ?2, ?3)"),
      same(impl_->database, "SELECT count(*) FROM points WHERE id = ?1 AND settings = ?2 AND seed = ?3");
  const auto bind = [](Statement& statement, const StudyPoint& point) -> Statement& {
    return statement.bind(1, point.id)
        .bind(2, Json(point.settings).dump())
        .bind(3, static_cast<std::int64_t>(point.seed));
  };
  for (const StudyPoint& point : points) {
    bind(insert, point).run();
    if (!bind(same, point).is_true())
      impl_->database.refuse_damage(
          fmt::format("row {} is another point than the study has there", point.id));
    impl_->ids.insert(point.id);
  }
  transaction.commit();
}

void StudyStore::record(const std::vector<PointOutcome>& outcomes) {
  Transaction transaction(impl_->database);
  Statement update(impl_->database,
                   "UPDATE points SET status = ?2, reason = ?3, results = ?4, seconds = ?5, traced = ?6, "
                   "version = ?7, host = ?8, finished_at = ?9, digest = ?10 WHERE id = ?1 AND status = "
                   "'pending'");
  for (const PointOutcome& outcome : outcomes) {
    Finish row{outcome.id,
               outcome.failed ? "failed" : "done",
               outcome.reason,
               Json(outcome.numbers).dump(),  // what is not finite becomes null
               outcome.seconds > 0.0 && std::isfinite(outcome.seconds) ? outcome.seconds : 0.0,
               outcome.traced ? 1 : 0,
               outcome.version.empty() ? impl_->version : outcome.version,
               outcome.host.empty() ? impl_->host : outcome.host,
               utc_now()};
    update.bind(1, row.id)
        .bind(2, row.status)
        .bind(3, row.reason)
        .bind(4, row.results)
        .bind(5, row.seconds)
        .bind(6, row.traced)
        .bind(7, row.version)
        .bind(8, row.host)
        .bind(9, row.finished_at)
        .bind(10, row.digest(impl_->digest))
        .run();
  }
  transaction.commit();
}

std::vector<StoredPoint> StudyStore::rows(std::int64_t first_id, std::int64_t last_id) const {
  Statement select(impl_->database,
                   "SELECT id, settings, seed, status, reason, results, seconds, traced, version, host, "
                   "finished_at, digest FROM points WHERE id BETWEEN ?1 AND ?2 ORDER BY id");
  select.bind(1, first_id).bind(2, last_id);
  std::vector<StoredPoint> rows;
  while (select.step()) {
    const Finish row{select.integer(0), select.text(3), select.text(4), select.text(5), select.real(6),
                     select.integer(7), select.text(8), select.text(9), select.text(10)};
    const auto refuse_row = [&] { impl_->database.refuse_damage(fmt::format("row {} is damaged", row.id)); };
    if (row.status != "pending" && select.text(11) != row.digest(impl_->digest)) refuse_row();
    const std::string settings = select.text(1);
    StoredPoint& out = rows.emplace_back();
    try {
      out.point = {row.id, parse_json<Json>(settings).get<Settings>(),
                   static_cast<std::uint64_t>(select.integer(2))};
      if (row.status != "pending") out.outcome = row.outcome();
    } catch (const Json::exception&) {
      refuse_row();
    } catch (const std::out_of_range&) {
      refuse_row();
    }
    out.status = status_of(row.status);
    out.outcome.id = row.id;
    out.version = row.version;
    out.host = row.host;
    out.finished_at = row.finished_at;
  }
  return rows;
}

std::vector<StoredPoint> StudyStore::finished_rows() const {
  // A stranger's million rows are not read to be refused.
  const bool as_many = impl_->database.integer("SELECT count(*) FROM points") == std::ssize(impl_->ids);
  std::vector<StoredPoint> all;
  if (as_many) all = rows(std::numeric_limits<std::int64_t>::min());
  if (!as_many ||
      !std::ranges::equal(all, impl_->ids, {}, [](const StoredPoint& row) { return row.point.id; }))
    impl_->database.refuse_damage(fmt::format("has other rows than the {} of this study", impl_->ids.size()));
  for (const StoredPoint& row : all)
    if (row.status == PointStatus::pending)
      impl_->database.refuse_damage(fmt::format("row {} has lost its outcome", row.point.id));
  return all;
}

void StudyStore::refuse_rows_from(std::int64_t n) const {
  Statement foreign(impl_->database, "SELECT id FROM points WHERE id < 0 OR id >= ?1 LIMIT 1");
  if (foreign.bind(1, n).step())
    impl_->database.refuse_damage(
        fmt::format("row {} is none of the study's points 0 ... {}", foreign.integer(0), n - 1));
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
