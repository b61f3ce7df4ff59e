// SPDX-License-Identifier: Apache-2.0
#include "study/store/sqlite.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>

#include "twin/base/errors.hpp"
#include "twin/base/out_of_memory.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/safe_file.hpp"

namespace fringetwin::study {
namespace {

constexpr int kPatienceMs = 120'000;  // another process's transaction is short; its disk may be slow
constexpr int kPauseMs = 10;

/// No text in the file is longer: the longest is that of the study, which came from a file of this kind.
int longest_text() {
  constexpr auto kMost = static_cast<std::uintmax_t>(std::numeric_limits<int>::max());
  return static_cast<int>(std::min(largest_file_bytes(FileKind::text), kMost));
}

/// Returns whether there is memory for what a sound file takes at a time.
bool has_memory() {
  constexpr sqlite3_uint64 kEnough = 64 << 20;
  void* memory = sqlite3_malloc64(kEnough);
  sqlite3_free(memory);
  return memory != nullptr;
}

/// SQLite calls it while another process holds the file; 0: no more patience.
int be_patient(void*, int times) {
  std::this_thread::sleep_for(std::chrono::milliseconds(kPauseMs));
  return !cancelled() && times * kPauseMs < kPatienceMs ? 1 : 0;
}

}  // namespace

Database::Database(std::filesystem::path file) : file_(std::move(file)) {
  std::error_code error;
  if (std::filesystem::exists(file_, error))
    check_readable(file_, {.kind = FileKind::mesh, .what = "database of a study", .code = ExitCode::usage});
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX;
  const int code = sqlite3_open_v2(file_.c_str(), &handle_, flags, nullptr);
  try {
    check(code);
    if (sqlite3_db_readonly(handle_, "main") == 1) fail(SQLITE_READONLY);
    check(sqlite3_busy_handler(handle_, be_patient, nullptr));
    sqlite3_limit(handle_, SQLITE_LIMIT_LENGTH, longest_text());
    run("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON");
  } catch (...) {
    sqlite3_close(handle_);
    throw;
  }
}

Database::~Database() { sqlite3_close(handle_); }

void Database::use_write_ahead_log() {
  // Two processes that both change the mode of a new file are told "locked" without any patience.
  for (int waited_ms = 0;; waited_ms += kPauseMs) {
    const int code = sqlite3_exec(handle_, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr);
    throw_if_cancelled();
    if ((code & 0xff) != SQLITE_BUSY || waited_ms >= kPatienceMs) {
      check(code);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(kPauseMs));
  }
  run("PRAGMA synchronous = FULL");
}

void Database::run(const std::string& sql) const {
  check(sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr));
}

std::int64_t Database::integer(const char* sql) const {
  Statement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

void Database::refuse(const std::string& what, const std::string& hint, ExitCode code) const {
  throw UserError(code, file_.string(), what, hint);
}

void Database::refuse_damage(const std::string& what) const {
  refuse(what, "sqlite3 FILE .recover saves what can be read; give another --out", ExitCode::input);
}

void Database::check(int code) const {
  if (code != SQLITE_OK) fail(code);
}

void Database::fail(int code) const {
  if ((code & 0xff) == SQLITE_BUSY) throw_if_cancelled();  // which ends the patience
  const bool told = handle_ != nullptr && sqlite3_errcode(handle_) != SQLITE_OK;
  const std::string said = told ? sqlite3_errmsg(handle_) : sqlite3_errstr(code);
  switch (code & 0xff) {
    case SQLITE_NOMEM:  // also of a damaged file whose header announces a text of gigabytes
      if (!has_memory()) throw OutOfMemory("SQLite");
      refuse_damage(fmt::format("is damaged, or wants more memory than there is ({})", said));
    case SQLITE_NOTADB:
      refuse("is no SQLite database", "give another --out, or remove the file if nobody needs it",
             ExitCode::input);
    case SQLITE_CORRUPT:
      refuse_damage(fmt::format("is damaged ({})", said));
    case SQLITE_TOOBIG:
      refuse_damage(fmt::format("is damaged (a text of more than {} bytes)", longest_text()));
    case SQLITE_CANTOPEN:
      refuse(fmt::format("cannot be opened ({})", said),
             "check the folder, its permissions and the room on the disk");
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      refuse(fmt::format("cannot be written ({})", said), "check its permissions and those of its folder");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      refuse(fmt::format("has been locked by another process for {} s", kPatienceMs / 1000),
             "what is stored is safe: run the command again when that process has ended");
    case SQLITE_FULL:
    case SQLITE_IOERR:
      refuse(fmt::format("cannot be written ({})", said),
             "what is stored is safe: if the disk is full, make room and run the command again");
    default:
      refuse(fmt::format("SQLite says: {}", said), "what is stored is safe");
  }
}

Statement::Statement(const Database& database, const char* sql) : database_(database) {
  database_.check(sqlite3_prepare_v2(database_.handle(), sql, -1, &statement_, nullptr));
}
Statement::~Statement() { sqlite3_finalize(statement_); }

Statement& Statement::bind(int place, std::int64_t value) {
  database_.check(sqlite3_bind_int64(statement_, place, value));
  return *this;
}
Statement& Statement::bind(int place, double value) {
  database_.check(sqlite3_bind_double(statement_, place, value));
  return *this;
}
Statement& Statement::bind(int place, const std::string& value) {
  database_.check(
      sqlite3_bind_text64(statement_, place, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.check(code);
  return code == SQLITE_ROW;
}
void Statement::run() {
  step();
  database_.check(sqlite3_reset(statement_));
}

bool Statement::is_true() {
  const bool is = step() && integer(0) != 0;
  database_.check(sqlite3_reset(statement_));
  return is;
}

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_, column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_, column); }
std::string Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_, column);  // before its size
  if (text == nullptr) return "";
  return {reinterpret_cast<const char*>(text),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

Transaction::Transaction(const Database& database) : database_(database) { database_.run("BEGIN IMMEDIATE"); }
Transaction::~Transaction() {
  if (!done_) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}
void Transaction::commit() {
  database_.run("COMMIT");
  done_ = true;
}

}  // namespace fringetwin::study
