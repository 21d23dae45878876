#pragma once
// A connection to the database of a library, SQLite or PostgreSQL. Used by store, and by programs that keep tables of their own.
//
// Both databases run the same SQL statements, with parameters ?1, ?2 ...; `Dialect` contains the parts of statements that differ.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {

/// Value of a statement's parameter. Texts and bytes are views: the memory must stay valid until the statement has run.
struct Value {
  enum class Type : std::uint8_t { null, integer, text, bytes };
  Type type = Type::null;
  std::int64_t number = 0;
  std::string_view text;
  std::span<const std::byte> bytes;

  Value() = default;
  Value(std::int64_t v) : type(Type::integer), number(v) {}
  Value(std::string_view v) : type(Type::text), text(v) {}
  Value(const std::string& v) : type(Type::text), text(v) {}
  Value(const char* v) : type(Type::text), text(v) {}
  Value(std::span<const std::byte> v) : type(Type::bytes), bytes(v) {}
};

/// All result rows of a statement.
class Rows {
 public:
  explicit Rows(int columns = 0) : columns_(static_cast<std::size_t>(columns)) {}
  [[nodiscard]] std::size_t size() const { return columns_ ? cells_.size() / columns_ : 0; }
  [[nodiscard]] bool empty() const { return cells_.empty(); }
  [[nodiscard]] const std::string& text(std::size_t row, std::size_t column) const { return cells_[row * columns_ + column].text; }
  [[nodiscard]] std::int64_t integer(std::size_t row, std::size_t column) const;
  [[nodiscard]] bool is_null(std::size_t row, std::size_t column) const { return cells_[row * columns_ + column].null; }
  void add(std::string text, bool null) { cells_.push_back({std::move(text), null}); }

 private:
  struct Cell {
    std::string text;
    bool null = false;
  };
  std::size_t columns_;
  std::vector<Cell> cells_;
};

/// Parts of SQL statements that differ between SQLite and PostgreSQL, and factors that tune the search (library_search.cpp).
struct Dialect {
  bool postgres = false;
  std::string now;    ///< expression: current UTC time, "2026-03-01T12:00:00.123Z"
  std::string instr;  ///< function: position of the second text in the first, counted from 1; 0 if not found
  std::string match;  ///< SELECT that returns the entries (column `no`) whose words match a query; {query} is replaced by a parameter
  /// Condition added to `match` for phrases of three or more words, with {query} as in `match`. Empty for SQLite. The index of PostgreSQL
  /// stores only pairs of adjacent words, so longer phrases are checked in the rows.
  std::string phrase_condition;
  std::string hit_source;    ///< FROM clause: entries of `hit` (the result of `match`) as `e`, with the columns no, id and the sort keys
  int sort_factor = 1;       ///< up to LibraryBody::sort_limit * sort_factor matches, sorting is faster than scanning rows in order
  double scan_fraction = 0;  ///< after LibraryBody::sort_limit * scan_fraction scanned rows, the search sorts the matches instead
  std::string lock_suffix;   ///< suffix of a SELECT that locks the selected rows
};

/// A database connection. Used by one thread at a time.
class Connection {
 public:
  Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  virtual ~Connection() = default;

  [[nodiscard]] virtual const Dialect& dialect() const = 0;
  /// Path of the file, or address of the server without the password.
  [[nodiscard]] virtual const std::string& location() const = 0;
  [[nodiscard]] virtual Result<Rows> query(std::string_view sql, std::span<const Value> parameters) = 0;
  [[nodiscard]] Result<Rows> query(std::string_view sql, std::initializer_list<Value> parameters = {}) {
    return query(sql, std::span<const Value>(parameters.begin(), parameters.size()));
  }
  /// The bytes in the first column of the first result row; empty optional if there is no row.
  [[nodiscard]] virtual Result<std::optional<std::vector<std::byte>>> bytes(std::string_view sql, std::span<const Value> parameters) = 0;
  /// Runs statements without parameters and without result, separated by semicolons.
  [[nodiscard]] virtual Result<void> script(const std::string& sql) = 0;

  enum class Access : std::uint8_t { read, write };
  /// Begins a transaction. A read transaction sees the same state of the database from its first statement to its end.
  [[nodiscard]] virtual Result<void> begin(Access access) = 0;
  [[nodiscard]] virtual Result<void> commit() = 0;
  virtual void rollback() = 0;
  /// True if the last error was caused by a concurrent transaction. The whole transaction should then be repeated.
  [[nodiscard]] virtual bool should_retry() const = 0;
  /// Runs the database's own integrity checks. @param problems receives the problems found
  [[nodiscard]] virtual Result<void> check(Error& problems) = 0;
  /// True if another connection changed the library since the previous call, or may have changed it. The first call begins to observe the
  /// changes and returns false. Reconnects if the connection was lost. Not to be called in a transaction.
  [[nodiscard]] virtual Result<bool> changed_elsewhere() = 0;
  /// Updates the statistics that the query planner uses. Call after many changes.
  [[nodiscard]] virtual Result<void> tidy() = 0;
};

/// Connection to the library in a SQLite file. @param database the opened file, already checked with check_library()
[[nodiscard]] std::unique_ptr<Connection> sqlite_connection(Database database);
/// Connection to a SQLite library that is open for writing. If another program replaces, removes or overwrites the file, the next call
/// fails with `conflict` and changes nothing; later calls use the file that is then at the path.
/// @param reopen opens the file at the path, which must be an existing library of the present version
[[nodiscard]] Result<std::unique_ptr<Connection>> watched_sqlite_connection(Database database, std::function<Result<Database>()> reopen);

/// True for "postgresql://..." and "postgres://...".
[[nodiscard]] bool is_postgres(std::string_view location);
/// The address without its password, for display.
[[nodiscard]] std::string without_password(std::string_view location);
/// Connects to a server. @param address "postgresql://user:password@host:port/database"; libpq takes missing parts from its environment
/// variables and files (PGPASSWORD, ~/.pgpass)
[[nodiscard]] Result<std::unique_ptr<Connection>> postgres_connection(const std::string& address, bool read_only);

}  // namespace ugoki::store
