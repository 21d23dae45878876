// A library in one SQLite file.

#include <map>

#include "ugoki/store/connection.h"

namespace ugoki::store {
namespace {

const Dialect sqlite_dialect = {
    .postgres = false,
    .now = "strftime('%Y-%m-%dT%H:%M:%fZ', 'now')",
    .instr = "instr",
    .match = "SELECT rowid AS no FROM entry_text WHERE entry_text MATCH {query}",
    .in_a_row = "",
    .hits = "hit h CROSS JOIN entry e ON e.no = h.no",
    .sorts = 1,
    .walks = 1.0 / 8,
    .update = "",
};

class SqliteConnection final : public Connection {
 public:
  explicit SqliteConnection(Database database) : database_(std::move(database)) {}
  ~SqliteConnection() override { rollback(); }

  const Dialect& dialect() const override { return sqlite_dialect; }
  const std::string& place() const override { return database_.path(); }
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
        problems.add(ErrorCode::syntax, place(), "The file is damaged: " + found->text(i, 0) + ".",
                     "Copy what can be read with `ugoki db copy`, or restore the file from a copy.");
    // A full-text index that does not fit its content is found by FTS5 itself.
    if (Result<void> text = database_.run("INSERT INTO entry_text (entry_text) VALUES ('integrity-check')");
        !text && text.error().problems.front().code == ErrorCode::syntax)  // not where the file may only be read
      problems.add(ErrorCode::syntax, place(), "The index of the full-text search is damaged.",
                   "Make it anew with `ugoki db check --repair`.");
    return {};
  }
  Result<void> tidy() override { return database_.run("PRAGMA optimize"); }

 private:
  /// The prepared statement, bound; kept for the next time.
  Result<Statement*> bound(std::string_view sql, std::span<const Value> parameters) {
    constexpr std::size_t most_kept = 200;
    auto kept = statements_.find(sql);
    if (kept == statements_.end()) {
      Result<Statement> prepared = database_.prepare(sql);
      if (!prepared) return fail(std::move(prepared.error()));
      if (statements_.size() >= most_kept) statements_.clear();
      kept = statements_.emplace(std::string(sql), std::move(*prepared)).first;
    }
    Statement& statement = kept->second;
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
  std::map<std::string, Statement, std::less<>> statements_;
  bool open_ = false;  ///< a transaction is
};

}  // namespace

std::unique_ptr<Connection> sqlite_connection(Database database) { return std::make_unique<SqliteConnection>(std::move(database)); }

}  // namespace ugoki::store
