// SPDX-License-Identifier: Apache-2.0
// SQLite with our errors: what goes wrong with a database becomes a sentence. Internal to study/.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace fringetwin::study {

/// An open file. All members throw UserError(usage) naming it.
class Database {
 public:
  /// Opens or makes the file, for writing; nothing is written yet.
  explicit Database(std::filesystem::path file);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Keeps what is committed in a write-ahead log: readers never wait, a commit is on the disk.
  void use_write_ahead_log();
  void run(const std::string& sql) const;
  /// The first column of the first row; 0 without one.
  std::int64_t integer(const char* sql) const;

  [[noreturn]] void refuse(const std::string& what, const std::string& hint) const;
  /// Throws for SQLite's answer unless it is SQLITE_OK.
  void check(int code) const;
  sqlite3* handle() const { return handle_; }

 private:
  [[noreturn]] void fail(int code) const;
  std::filesystem::path file_;
  sqlite3* handle_ = nullptr;
};

/// A prepared statement; places and columns as SQLite counts them, from 1 and from 0.
class Statement {
 public:
  Statement(const Database& database, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int place, std::int64_t value);
  Statement& bind(int place, double value);
  Statement& bind(int place, const std::string& value);
  bool step();  ///< false at the end of the rows
  void run();   ///< to its end, then ready for the next values
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;  ///< "" for NULL

 private:
  const Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

/// Of a writer; rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(const Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  const Database& database_;
  bool done_ = false;
};

}  // namespace fringetwin::study
