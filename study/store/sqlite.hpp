// SPDX-License-Identifier: Apache-2.0
// Wraps the SQLite library: statements go in as SQL text, rows come out, and every failure is thrown as a
// UserError whose sentence names the database file. Internal to study/.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace fringetwin::study {

/// Holds one open database file. All members throw a UserError that names the file: of code `input` where the
/// file is damaged, else `usage`.
class Database : NotCopyable {
 public:
  /// Opens or makes the file, for writing; nothing is written yet. No other connection of this process may
  /// have it open: looking at the file first would drop that one's locks.
  explicit Database(std::filesystem::path file);
  ~Database();

  /// Makes SQLite commit into a write-ahead log, so that readers never wait for a writer and a transaction is
  /// on the disk once it is committed.
  void use_write_ahead_log();
  /// Runs statements that return no rows.
  void run(const std::string& sql) const;
  /// Returns the first column of the query's first row; 0 when there is no row.
  std::int64_t integer(const char* sql) const;

  /// Throws a UserError that names the file, says `what` is wrong with it, and gives the hint.
  [[noreturn]] void refuse(const std::string& what, const std::string& hint,
                           ExitCode code = ExitCode::usage) const;
  /// Throws UserError(input): somebody or something else has changed the file.
  [[noreturn]] void refuse_damage(const std::string& what) const;
  /// Throws the message of SQLite unless its result code is SQLITE_OK.
  void check(int code) const;
  sqlite3* handle() const { return handle_; }

 private:
  [[noreturn]] void fail(int code) const;
  std::filesystem::path file_;
  sqlite3* handle_ = nullptr;
};

/// Holds one prepared statement. As in SQLite, the places of bound values count from 1, the columns of a row
/// from 0.
class Statement : NotCopyable {
 public:
  Statement(const Database& database, const char* sql);
  ~Statement();

  Statement& bind(int place, std::int64_t value);
  Statement& bind(int place, double value);
  Statement& bind(int place, const std::string& value);
  /// Goes to the next row; returns false when there is none left.
  bool step();
  /// Executes the statement to its end and resets it, so that the next values can be bound.
  void run();
  /// Returns whether the first row's first column is true, and resets the statement.
  bool is_true();
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;  ///< "" for NULL

 private:
  const Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

/// Opens a write transaction; the destructor rolls it back unless commit() was called.
class Transaction : NotCopyable {
 public:
  explicit Transaction(const Database& database);
  ~Transaction();
  void commit();

 private:
  const Database& database_;
  bool done_ = false;
};

}  // namespace fringetwin::study
