// A library in one SQLite file.

#include <map>
#include <utility>

#include "ugoki/store/connection.h"

namespace ugoki::store {
namespace {

const Dialect sqlite_dialect = {
    .postgres = false,
    .now = "strftime('%Y-%m-%dT%H:%M:%fZ', 'now')",
    .instr = "instr",
    .match = "SELECT rowid AS no FROM entry_text WHERE entry_text MATCH {query}",
    .phrase_condition = "",
    .hit_source = "hit h CROSS JOIN entry e ON e.no = h.no",
    .sort_factor = 1,
    .scan_fraction = 1.0 / 8,
    .lock_suffix = "",
};

class SqliteConnection final : public Connection {
 public:
  explicit SqliteConnection(Database database) : database_(std::move(database)) {}
  ~SqliteConnection() override { rollback(); }

  const Dialect& dialect() const override { return sqlite_dialect; }
  const std::string& location() const override { return database_.path(); }
  bool should_retry() const override { return false; }

  using Connection::query;
  Result<Rows> query(std::string_view sql, std::span<const Value> parameters) override {
    Result<Statement*> statement = bound(sql, parameters);
    if (!statement) return fail(std::move(statement.error()));
    const int columns = (*statement)->columns();
    Rows rows(columns);
    for (;;) {
      Result<bool> row = (*statement)->step();
      if (!row || !*row) (*statement)->reset();
      if (!row) return fail(std::move(row.error()));
      if (!*row) return rows;
      for (int c = 0; c < columns; ++c) rows.add((*statement)->text(c), (*statement)->is_null(c));
    }
  }

  Result<std::optional<std::vector<std::byte>>> bytes(std::string_view sql, std::span<const Value> parameters) override {
    Result<Statement*> statement = bound(sql, parameters);
    if (!statement) return fail(std::move(statement.error()));
    Result<bool> row = (*statement)->step();
    std::optional<std::vector<std::byte>> out;
    if (row && *row) out = (*statement)->blob(0);
    (*statement)->reset();
    if (!row) return fail(std::move(row.error()));
    return out;
  }

  Result<void> script(const std::string& sql) override { return database_.run(sql); }

  Result<void> begin(Access access) override {
    Result<void> begun = database_.run(access == Access::write ? "BEGIN IMMEDIATE" : "BEGIN");
    open_ = begun.has_value();
    return begun;
  }
  Result<void> commit() override {
    Result<void> done = database_.run("COMMIT");
    if (!done)
      rollback();
    else
      open_ = false;
    return done;
  }
  void rollback() override {
    if (open_) (void)database_.run("ROLLBACK");
    open_ = false;
  }

  Result<void> check(Error& problems) override {
    Result<Rows> found = query("PRAGMA integrity_check(20)");
    if (!found) return fail(std::move(found.error()));
    for (std::size_t i = 0; i < found->size(); ++i)
      if (found->text(i, 0) != "ok")
        problems.add(ErrorCode::syntax, location(), "The file is damaged: " + found->text(i, 0) + ".",
                     "Copy the readable entries with `ugoki db copy`, or restore the file from a backup.");
    // The FTS5 command 'integrity-check' finds a damaged full-text index.
    if (Result<void> text = database_.run("INSERT INTO entry_text (entry_text) VALUES ('integrity-check')");
        !text && text.error().problems.front().code == ErrorCode::syntax)  // other errors: the file is opened read-only
      problems.add(ErrorCode::syntax, location(), "The index of the full-text search is damaged.",
                   "Rebuild it with `ugoki db check --repair`.");
    return {};
  }
  Result<void> tidy() override { return database_.run("PRAGMA optimize"); }

  Result<bool> changed_elsewhere() override {
    const Result<Rows> rows = query("PRAGMA data_version");  // a counter of the commits of other connections
    if (!rows) return fail(rows.error());
    const std::int64_t before = std::exchange(data_version_, rows->integer(0, 0));
    return before != 0 && before != data_version_;
  }

 private:
  /// The prepared statement with its parameters bound. Prepared statements are cached.
  Result<Statement*> bound(std::string_view sql, std::span<const Value> parameters) {
    constexpr std::size_t max_cached = 200;  // the cache is cleared when it is full
    auto cached = statements_.find(sql);
    if (cached == statements_.end()) {
      Result<Statement> prepared = database_.prepare(sql);
      if (!prepared) return fail(std::move(prepared.error()));
      if (statements_.size() >= max_cached) statements_.clear();
      cached = statements_.emplace(std::string(sql), std::move(*prepared)).first;
    }
    Statement& statement = cached->second;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Value& v = parameters[i];
      const int at = static_cast<int>(i + 1);
      switch (v.type) {
        case Value::Type::null: statement.bind_null(at); break;
        case Value::Type::integer: statement.bind(at, v.number); break;
        case Value::Type::text: statement.bind(at, v.text); break;
        case Value::Type::bytes: statement.bind_blob(at, v.bytes); break;
      }
    }
    return &statement;
  }

  Database database_;
  std::map<std::string, Statement, std::less<>> statements_;  ///< by their SQL
  bool open_ = false;                                         ///< a transaction is open
  std::int64_t data_version_ = 0;                             ///< of the last changed_elsewhere(); 0: it was not called
};

}  // namespace

std::unique_ptr<Connection> sqlite_connection(Database database) { return std::make_unique<SqliteConnection>(std::move(database)); }

}  // namespace ugoki::store
