// A library in one SQLite file.

#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "ugoki/store/connection.h"
#include "ugoki/store/file_watch.h"
#include "ugoki/store/rescue.h"
#include "ugoki/store/stamp.h"

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
  explicit SqliteConnection(Database database) : location_(database.path()), database_(std::move(database)) {}
  ~SqliteConnection() override { rollback(); }

  const Dialect& dialect() const override { return sqlite_dialect; }
  const std::string& location() const override { return location_; }
  bool should_retry() const override { return false; }

  /// Begins to observe the file. @param reopen as in watched_sqlite_connection()
  Result<void> watch(std::function<Result<Database>()> reopen) {
    Result<FileWatch> begun = FileWatch::begin(*database_);
    if (!begun) return fail(std::move(begun.error()));
    watch_ = std::move(*begun);
    reopen_ = std::move(reopen);
    return {};
  }

  using Connection::query;
  Result<Rows> query(std::string_view sql, std::span<const Value> parameters) override {
    if (Result<void> ready = prepare(); !ready) return fail(std::move(ready.error()));
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
    if (Result<void> ready = prepare(); !ready) return fail(std::move(ready.error()));
    Result<Statement*> statement = bound(sql, parameters);
    if (!statement) return fail(std::move(statement.error()));
    Result<bool> row = (*statement)->step();
    std::optional<std::vector<std::byte>> out;
    if (row && *row) out = (*statement)->blob(0);
    (*statement)->reset();
    if (!row) return fail(std::move(row.error()));
    return out;
  }

  Result<void> script(const std::string& sql) override {
    if (Result<void> ready = prepare(); !ready) return ready;
    return database_->run(sql);
  }

  Result<void> begin(Access access) override {
    if (Result<void> ready = prepare(); !ready) return ready;
    Result<void> begun = database_->run(access == Access::write ? "BEGIN IMMEDIATE" : "BEGIN");
    if (!begun) return begun;
    open_ = true;
    writing_ = access == Access::write;
    if (writing_ && watch_)
      if (const std::optional<FileLoss> loss = watch_->overwritten(*database_); loss) return lose(*loss);
    return {};
  }
  Result<void> commit() override {
    std::optional<StampRow> stamp;
    if (writing_) {
      Result<void> advanced = advance_stamp(*database_);
      if (advanced) {
        Result<std::optional<StampRow>> read = read_stamp(*database_);
        if (read)
          stamp = *read;
        else
          advanced = fail(std::move(read.error()));
      }
      if (!advanced) {
        rollback();
        return advanced;
      }
    }
    Result<void> done = database_->run("COMMIT");
    if (!done) {
      rollback();
      return done;
    }
    open_ = false;
    if (!writing_ || !watch_) return {};
    writing_ = false;
    // If the file was replaced during the transaction, the changes are only in the old file.
    if (const std::optional<FileLoss> loss = watch_->moved(); loss) return lose(*loss);
    if (const std::optional<FileLoss> loss = watch_->overwritten(*database_, stamp); loss) return lose(*loss);
    return {};
  }
  void rollback() override {
    if (open_ && database_) (void)database_->run("ROLLBACK");
    open_ = writing_ = false;
  }

  Result<void> check(Error& problems) override {
    Result<Rows> found = query("PRAGMA integrity_check(20)");
    if (!found) return fail(std::move(found.error()));
    for (std::size_t i = 0; i < found->size(); ++i)
      if (found->text(i, 0) != "ok")
        problems.add(ErrorCode::syntax, location(), "The file is damaged: " + found->text(i, 0) + ".",
                     "Copy the readable entries with `ugoki db copy`, or restore the file from a backup.");
    // The FTS5 command 'integrity-check' finds a damaged full-text index.
    if (Result<void> text = database_->run("INSERT INTO entry_text (entry_text) VALUES ('integrity-check')");
        !text && text.error().problems.front().code == ErrorCode::syntax)  // other errors occur if the file is read-only
      problems.add(ErrorCode::syntax, location(), "The index of the full-text search is damaged.",
                   "Rebuild it with `ugoki db check --repair`.");
    return {};
  }
  Result<void> tidy() override {
    if (Result<void> ready = prepare(); !ready) return ready;
    return database_->run("PRAGMA optimize");
  }

  Result<bool> changed_elsewhere() override {
    if (watch_ && database_)
      if (const std::optional<FileLoss> loss = watch_->moved(); loss) (void)lose(*loss);
    const bool reopened = !database_;
    const Result<Rows> rows = query("PRAGMA data_version");  // counts the commits of other connections
    if (!rows) return fail(rows.error());
    const std::int64_t before = std::exchange(data_version_, rows->integer(0, 0));
    return before != 0 && (reopened || before != data_version_);
  }

 private:
  /// Ensures, outside of a transaction, that the connection uses the file at its path. Opens the file again after a loss.
  Result<void> prepare() {
    if (open_ || !watch_) return {};
    if (database_) {
      if (const std::optional<FileLoss> loss = watch_->moved(); loss) return lose(*loss);
      return {};
    }
    Result<Database> again = reopen_();
    if (!again) return fail(std::move(again.error()));
    Result<FileWatch> watch = FileWatch::begin(*again);
    if (!watch) return fail(std::move(watch.error()));
    watch_ = std::move(*watch);
    database_ = std::move(*again);
    return {};
  }

  /// Closes the lost file. Saves a rescue copy first if the file has no name any more. @return the error that describes the loss
  std::unexpected<Error> lose(const FileLoss& loss) {
    rollback();
    statements_.clear();
    std::string rescued;
    // SQLite does not merge the log when it closes a file that was moved, so the log is merged here. If another program reads the file, the
    // log cannot be merged and is kept, unless there is a complete copy. The log of an overwritten file is not merged: it would damage it.
    bool merged = !loss.readable;
    if (loss.readable) {
      const Result<std::int64_t> busy = database_->integer("PRAGMA wal_checkpoint(TRUNCATE)");
      merged = busy && *busy == 0;
    }
    if (loss.unlinked && loss.readable) {
      const Result<std::string> copy = make_rescue_copy(location_, [&](const std::string& file) -> Result<void> {
        Result<Statement> vacuum = database_->prepare("VACUUM INTO ?1");
        return vacuum ? vacuum->bind(1, file).run() : fail(vacuum.error());
      });
      merged = merged || copy;
      rescued =
          copy ? " The library as it was is in the rescue copy " + *copy + "." : " No rescue copy could be written: " + copy.error().text();
    }
    database_->keep_log_when_closed();
    if (merged) watch_->remove_side_files();
    database_.reset();
    return fail(ErrorCode::conflict, location_, loss.what + "; an unfinished change was not saved." + rescued,
                "Try again to use the file that is now at this path.");
  }

  /// The prepared statement with its parameters bound. Prepared statements are cached.
  Result<Statement*> bound(std::string_view sql, std::span<const Value> parameters) {
    constexpr std::size_t max_cached = 200;  // the cache is cleared when it is full
    auto cached = statements_.find(sql);
    if (cached == statements_.end()) {
      Result<Statement> prepared = database_->prepare(sql);
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

  std::string location_;
  std::optional<FileWatch> watch_;    ///< observes the file; empty: the library is open read-only
  std::optional<Database> database_;  ///< empty: the file was lost, and prepare() opens it again
  std::function<Result<Database>()> reopen_;
  bool writing_ = false;                                      ///< true: the open transaction is a write transaction
  std::map<std::string, Statement, std::less<>> statements_;  ///< prepared statements, by their SQL text
  bool open_ = false;                                         ///< true: a transaction is open
  std::int64_t data_version_ = 0;                             ///< PRAGMA data_version at the last changed_elsewhere(); 0: not called yet
};

}  // namespace

std::unique_ptr<Connection> sqlite_connection(Database database) { return std::make_unique<SqliteConnection>(std::move(database)); }

Result<std::unique_ptr<Connection>> watched_sqlite_connection(Database database, std::function<Result<Database>()> reopen) {
  auto connection = std::make_unique<SqliteConnection>(std::move(database));
  if (Result<void> done = connection->watch(std::move(reopen)); !done) return fail(std::move(done.error()));
  return connection;
}

}  // namespace ugoki::store
