#pragma once
// A connection to the database that holds a library, SQLite or PostgreSQL. Internal to store.
//
// The statements are the same for both, with parameters ?1, ?2 ...; what their dialects spell differently is taken from `Dialect`.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {

/// A parameter. Texts and bytes are views: they must live until the statement has run.
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

/// The answer to a statement, complete.
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

/// What the two languages spell differently.
struct Dialect {
  bool postgres = false;
  std::string now;    ///< expression: UTC now, "2026-03-01T12:00:00.123Z"
  std::string instr;  ///< function: where the second text stands in the first, 0 if nowhere
  std::string match;  ///< SELECT of the entries (as `no`) whose words match the next parameter, which replaces {query}
  /// Condition of `match` where three words or more must stand in a row, again with {query}: the index of PostgreSQL only knows pairs.
  std::string in_a_row;
  std::string hits;    ///< FROM of the result `hit` of that: no, id and what is sorted by, as columns of `e`
  int sorts = 1;       ///< so many times `few` entries are sorted faster than others are read in order
  double walks = 0;    ///< such a part of `few` is read in order before what fits is sorted after all
  std::string update;  ///< suffix of a SELECT that locks the rows it finds
};

/// Used by one thread at a time.
class Connection {
 public:
  Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  virtual ~Connection() = default;

  [[nodiscard]] virtual const Dialect& dialect() const = 0;
  /// The file, or the server without any password.
  [[nodiscard]] virtual const std::string& place() const = 0;
  [[nodiscard]] virtual Result<Rows> query(std::string_view sql, std::span<const Value> parameters) = 0;
  [[nodiscard]] Result<Rows> query(std::string_view sql, std::initializer_list<Value> parameters = {}) {
    return query(sql, std::span<const Value>(parameters.begin(), parameters.size()));
  }
  /// The first column of the first row as bytes; nothing where there is no row.
  [[nodiscard]] virtual Result<std::optional<std::vector<std::byte>>> bytes(std::string_view sql, std::span<const Value> parameters) = 0;
  /// Statements without parameters and answer, separated by semicolons.
  [[nodiscard]] virtual Result<void> script(const std::string& sql) = 0;

  enum class Access : std::uint8_t { read, write };
  /// Reading sees one state of the database from the first statement to the end.
  [[nodiscard]] virtual Result<void> begin(Access access) = 0;
  [[nodiscard]] virtual Result<void> commit() = 0;
  virtual void rollback() = 0;
  /// True if the last error came from another's work at the same time, or from a connection lost before the end: doing the transaction
  /// again is right.
  [[nodiscard]] virtual bool should_retry() const = 0;
  /// Everything that the database itself can say about its health. @param problems gets what is wrong
  [[nodiscard]] virtual Result<void> check(Error& problems) = 0;
  /// After many changes: brings up to date what the database knows about the tables, so that it searches well.
  [[nodiscard]] virtual Result<void> tidy() = 0;
};

/// @param database of a library, checked and brought up to date
[[nodiscard]] std::unique_ptr<Connection> sqlite_connection(Database database);

/// True for "postgresql://..." and "postgres://...".
[[nodiscard]] bool is_postgres(std::string_view place);
/// The address without password, for people.
[[nodiscard]] std::string without_password(std::string_view place);
/// @param address "postgresql://user:password@host:port/database"; what it leaves out comes from libpq's environment and files
[[nodiscard]] Result<std::unique_ptr<Connection>> postgres_connection(const std::string& address, bool read_only);

}  // namespace ugoki::store
