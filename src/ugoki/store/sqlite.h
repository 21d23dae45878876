#pragma once
// Wrapper of SQLite that returns Result instead of error codes.

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
  read_only,       ///< never writes to the database; leaves no -wal and -shm files of its own
  read_write,      ///< reads and writes; the file must exist
  create,          ///< reads and writes; a file that does not exist is created with mode 0600
  main_file_only,  ///< never writes, takes no locks, and ignores the write-ahead log
};

/// A connection to a SQLite file. Used by one thread at a time.
class Database {
 public:
  /// Opens the database file `path`; ":memory:" makes a database in memory that exists as long as the connection. With read_only, a file in
  /// write-ahead-log mode can be opened even if its folder is not writable.
  [[nodiscard]] static Result<Database> open(const std::string& path, OpenMode mode);
  Database(Database&& other) noexcept;
  Database& operator=(Database&& other) noexcept;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  /// Runs statements, separated by semicolons, and ignores the rows they return.
  [[nodiscard]] Result<void> run(const std::string& sql);
  [[nodiscard]] Result<Statement> prepare(std::string_view sql);
  /// The integer in the first column of the first row, or 0 if there is no row; for pragmas and counts.
  [[nodiscard]] Result<std::int64_t> integer(const std::string& sql);
  /// The text in the first column of the first row, or an empty text if there is no row.
  [[nodiscard]] Result<std::string> text(const std::string& sql);
  /// Checks the structure of the file (PRAGMA quick_check). Error `syntax` if it is damaged.
  [[nodiscard]] Result<void> check_structure();
  /// Reads `size` bytes at `offset` of the database file, fewer at its end. Uses the open descriptor and ignores the write-ahead log.
  [[nodiscard]] Result<std::vector<std::byte>> raw(std::int64_t offset, std::size_t size);
  /// A copy of the database in memory. Its error messages name the path of this database.
  [[nodiscard]] Result<Database> copy_to_memory();
  /// True if the path no longer names the open file.
  [[nodiscard]] bool has_moved();
  /// From now on, closing this connection neither merges the write-ahead log into the file nor removes it.
  void keep_log_when_closed();
  [[nodiscard]] const std::string& path() const { return path_; }
  /// The last error of this connection with a message for users. @param action failed action, begins the message; may be empty
  [[nodiscard]] Error last_error(std::string_view action) const;

 private:
  friend class Statement;
  /// Opens `name`, which may be a URI. @param path file path that error messages show
  [[nodiscard]] static Result<Database> connect(const std::string& name, const std::string& path, int flags);
  Database(sqlite3* handle, std::string path) : handle_(handle), path_(std::move(path)) {}
  sqlite3* handle_ = nullptr;
  std::string path_;
};

/// A prepared statement with numbered parameters ?1, ?2 ... Must not outlive its database.
class Statement {
 public:
  Statement(Statement&& other) noexcept;
  Statement& operator=(Statement&& other) noexcept;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement();

  // Each of these functions sets the parameter `index`, counted from 1. Texts and bytes are copied.
  Statement& bind(int index, std::int64_t value);
  Statement& bind(int index, std::string_view value);
  Statement& bind_blob(int index, std::span<const std::byte> value);
  Statement& bind_null(int index);
  /// Advances to the next row. True: there is a row; false: the statement has finished.
  [[nodiscard]] Result<bool> step();
  /// Runs to the end and resets the statement, so that it can be bound and run again.
  [[nodiscard]] Result<void> run();
  /// Resets the statement, so that it can be bound and stepped again.
  void reset();
  // Values of the current row; `column` counts from 0.
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

/// A write transaction. The destructor rolls it back unless commit() succeeded.
class Transaction {
 public:
  /// Begins a transaction and acquires the write lock at once (BEGIN IMMEDIATE).
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
