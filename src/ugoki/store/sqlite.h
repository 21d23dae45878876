#pragma once
// SQLite with Result instead of error codes. One Database is one connection, used by one thread at a time.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace ugoki::store {

class Statement;

enum class OpenMode {
  read_only,   ///< never writes, not even to repair
  read_write,  ///< the file must exist
  create,      ///< made if it does not exist
};

class Database {
 public:
  /// Opens a file; ":memory:" is a database that dies with the connection. A file in write-ahead-log mode whose folder
  /// cannot be written is read as it is.
  [[nodiscard]] static Result<Database> open(const std::string& path, OpenMode mode);
  Database(Database&& other) noexcept;
  Database& operator=(Database&& other) noexcept;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  /// Runs statements that return no rows, or whose rows do not matter.
  [[nodiscard]] Result<void> run(const std::string& sql);
  [[nodiscard]] Result<Statement> prepare(std::string_view sql);
  /// First column of the first row, 0 if there is none: for pragmas and counts.
  [[nodiscard]] Result<std::int64_t> integer(const std::string& sql);
  [[nodiscard]] Result<std::string> text(const std::string& sql);
  /// Says what is broken in the file's structure (`quick_check`), or nothing.
  [[nodiscard]] Result<void> check_structure();
  [[nodiscard]] const std::string& path() const { return path_; }
  /// SQLite's last code and message on this connection as a problem that people understand.
  [[nodiscard]] Error last_error(std::string_view doing) const;

 private:
  friend class Statement;
  Database(sqlite3* handle, std::string path) : handle_(handle), path_(std::move(path)) {}
  sqlite3* handle_ = nullptr;
  std::string path_;
};

/// A prepared statement with numbered parameters (?1 ...). Must not outlive its database.
class Statement {
 public:
  Statement(Statement&& other) noexcept;
  Statement& operator=(Statement&& other) noexcept;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement();

  Statement& bind(int index, std::int64_t value);
  Statement& bind(int index, std::string_view value);
  Statement& bind_blob(int index, std::span<const std::byte> value);
  Statement& bind_null(int index);
  /// True: there is a row; false: finished.
  [[nodiscard]] Result<bool> step();
  /// Runs to the end, and can then be bound and run again.
  [[nodiscard]] Result<void> run();
  /// Back to the beginning, so that it can be bound and stepped again.
  void reset();
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::vector<std::byte> blob(int column) const;
  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] int columns() const;

 private:
  friend class Database;
  Statement(const Database& database, sqlite3_stmt* handle) : path_(database.path_), handle_(handle) {}
  std::string path_;
  sqlite3_stmt* handle_ = nullptr;
};

/// Everything between construction and commit() happens wholly or not at all.
class Transaction {
 public:
  /// Takes the write lock at once (BEGIN IMMEDIATE).
  [[nodiscard]] static Result<Transaction> begin(Database& database);
  Transaction(Transaction&& other) noexcept : database_(other.database_) { other.database_ = nullptr; }
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();
  [[nodiscard]] Result<void> commit();

 private:
  explicit Transaction(Database& database) : database_(&database) {}
  Database* database_;
};

}  // namespace ugoki::store
