#include "sweep_table.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "output.h"
#include "ugoki/base/number.h"
#include "ugoki/store/library.h"

namespace ugoki::cli {

using sweep::check_address;
using sweep::quoted;
using sweep::table_name;
using sweep::TableAddress;

namespace {

/// Returns true if all values of a quantity are numbers.
bool is_numeric(const Variation& v) {
  return std::ranges::all_of(v.values, [](const std::string& text) { return parse_double(text).has_value(); });
}

}  // namespace

namespace {
/// Refuses an existing file that is not a table of `ugoki bake`. Empty files and databases without tables are accepted.
Result<void> check_table_file(const std::string& path) {
  std::error_code none;
  if (!std::filesystem::exists(path, none)) return {};
  const auto refuse = [&] {
    return fail(ErrorCode::conflict, path, "The file exists, but is not a table of `ugoki bake`.", "Name another file for the table.");
  };
  if (!std::filesystem::is_regular_file(path, none)) return refuse();
  if (std::filesystem::file_size(path, none) == 0) return {};
  Result<store::Database> database = store::Database::open(path, store::OpenMode::read_only);
  if (!database) return fail(std::move(database.error()));
  const Result<std::int64_t> application = database->integer("PRAGMA application_id");
  if (!application) return fail(application.error());
  if (*application != 0) return refuse();
  const Result<std::int64_t> tables = database->integer("SELECT count(*) FROM sqlite_master");
  if (tables && *tables == 0) return {};  // left by a `bake` that ended before it wrote its plan
  if (const Result<std::string> plan = database->text("SELECT value FROM property WHERE name = 'plan'"); !plan || plan->empty())
    return refuse();
  return {};
}
}  // namespace

SweepTable::~SweepTable() {
  if (lock_ >= 0) ::close(lock_);
}

Result<SweepTable> SweepTable::open(const TableAddress& address, const SweepPlan& plan) {
  if (Result<void> good = check_address(address); !good) return fail(std::move(good.error()));
  const std::string& path = address.location;
  if (store::is_postgres(path)) {
    // Opening the library creates the schema `ugoki` in an empty database.
    if (Result<store::Library> library = store::Library::open(path); !library) return fail(std::move(library.error()));
    Result<std::unique_ptr<store::Connection>> connection = store::postgres_connection(path, false);
    if (!connection) return fail(std::move(connection.error()));
    SweepTable table(std::move(*connection), -1);
    if (Result<void> begun = table.connection_->begin(store::Connection::Access::write); !begun) return fail(std::move(begun.error()));
    // The lock makes tasks that start at the same time create the table one after the other. The end of the transaction releases it.
    if (Result<store::Rows> lock = table.connection_->query("SELECT pg_advisory_xact_lock(1431786317)::text"); !lock)
      return fail(std::move(lock.error()));
    Result<void> done = table.prepare(address, plan);
    if (done) done = table.connection_->commit();
    if (!done) {
      table.connection_->rollback();
      return fail(std::move(done.error()));
    }
    return table;
  }
  if (Result<void> may = check_table_file(path); !may) return fail(std::move(may.error()));
  const int lock = ::open((path + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock < 0)
    return fail(ErrorCode::io, path, "The lock file beside the table cannot be written.", "Choose a folder that may be written.");
  if (::flock(lock, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock);
    return fail(ErrorCode::conflict, path, "Another `ugoki bake` writes this table.", "Wait for its end, or name another table.");
  }
  Result<store::Database> database = store::Database::open(path, store::OpenMode::create);
  if (!database) {
    ::close(lock);
    return fail(std::move(database.error()));
  }
  SweepTable table(store::sqlite_connection(std::move(*database)), lock);
  if (Result<void> done = table.connection_->script("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL"); !done)
    return fail(std::move(done.error()));
  if (Result<void> done = table.prepare(address, plan); !done) return fail(std::move(done.error()));
  return table;
}

/// Creates missing tables. Fails if the stored plan differs from `plan`.
Result<void> SweepTable::prepare(const TableAddress& address, const SweepPlan& plan) {
  const bool server = store::is_postgres(address.location);
  table_ = table_name(address);
  plan_ = plan.text();
  std::string sql = "CREATE TABLE IF NOT EXISTS " + table_ + " (number INTEGER PRIMARY KEY, target TEXT NOT NULL";
  columns_ = {"number", "target"};
  const auto add = [&](const std::string& name, const char* type) {
    if (std::ranges::find(columns_, name) != columns_.end()) return;
    columns_.push_back(name);
    sql += ", " + quoted(name) + ' ' + type;
  };
  for (const Variation& v : plan.variations) add(v.name, !server ? "NUMERIC" : is_numeric(v) ? "DOUBLE PRECISION" : "TEXT");
  add("status", "TEXT NOT NULL");
  add("message", "TEXT");
  add("steps", "INTEGER");
  add("processor_s", "DOUBLE PRECISION");
  add("state_hash", "TEXT");
  for (const std::string& m : sweep_measures()) add(m, "DOUBLE PRECISION");
  sql += ")";
  const char* plans = server ? "CREATE TABLE IF NOT EXISTS sweep (name TEXT PRIMARY KEY, value TEXT)"
                             : "CREATE TABLE IF NOT EXISTS property (name TEXT PRIMARY KEY, value TEXT)";
  const std::string plan_table = server ? "sweep" : "property", name = server ? address.name : "plan";
  if (Result<store::Rows> done = connection_->query(plans); !done) return fail(std::move(done.error()));
  const Result<store::Rows> stored = connection_->query("SELECT value FROM " + plan_table + " WHERE name = ?1", {name});
  if (!stored) return fail(stored.error());
  if (stored->empty()) {
    if (Result<store::Rows> done = connection_->query("INSERT INTO " + plan_table + " VALUES (?1, ?2)", {name, plan_}); !done)
      return fail(std::move(done.error()));
  } else if (stored->text(0, 0) != plan_) {
    return fail(ErrorCode::conflict, server ? "--name " + name : address.location,
                "The table belongs to another sweep: targets, their content, variations or duration differ.",
                "Repeat that sweep with the same options, or name another table.");
  }
  if (Result<store::Rows> done = connection_->query(sql); !done) return fail(std::move(done.error()));
  return {};
}

Result<std::vector<std::uint64_t>> SweepTable::finished() {
  const Result<store::Rows> rows = connection_->query("SELECT number FROM " + table_ + " ORDER BY number");
  if (!rows) return fail(rows.error());
  std::vector<std::uint64_t> out(rows->size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint64_t>(rows->integer(i, 0));
  return out;
}

Result<SweepFailures> SweepTable::failures(std::uint64_t index, std::uint64_t parts) {
  const Result<store::Rows> rows =
      connection_->query("SELECT number, status, message FROM " + table_ + " WHERE status <> 'done' AND number % ?1 = ?2 ORDER BY number",
                         {static_cast<std::int64_t>(parts), static_cast<std::int64_t>(index)});
  if (!rows) return fail(rows.error());
  SweepFailures out;
  out.count = rows->size();
  if (!rows->empty()) out.first = "run " + std::to_string(rows->integer(0, 0)) + ", " + rows->text(0, 1) + ": " + rows->text(0, 2);
  return out;
}

/// Inserts a row, unless the table has a row with the same number. @return true if the row was inserted
Result<bool> SweepTable::insert(const std::vector<store::Value>& cells) {
  std::string places;
  for (std::size_t i = 1; i <= cells.size(); ++i) places += (i > 1 ? ", ?" : "?") + std::to_string(i);
  const Result<store::Rows> rows = connection_->query(
      "INSERT INTO " + table_ + " VALUES (" + places + ") ON CONFLICT (number) DO NOTHING RETURNING number", std::span(cells));
  if (!rows) return fail(rows.error());
  return !rows->empty();
}

Result<void> SweepTable::add(std::uint64_t number, const std::string& target, const std::vector<std::string>& values, const Json& row) {
  std::vector<std::string> texts(columns_.size());
  std::vector<store::Value> cells(columns_.size());
  cells[0] = static_cast<std::int64_t>(number);
  cells[1] = target;
  for (std::size_t i = 2; i < columns_.size(); ++i) {
    if (i - 2 < values.size()) {
      cells[i] = values[i - 2];
      continue;
    }
    const auto found = row.find(columns_[i]);
    if (found == row.end() || found->is_null()) continue;
    if (found->is_string())
      texts[i] = found->get<std::string>();
    else if (found->is_boolean())
      texts[i] = found->get<bool>() ? "1" : "0";
    else if (found->is_number_integer())
      texts[i] = std::to_string(found->get<std::int64_t>());
    else
      texts[i] = to_text(found->get<double>());
    cells[i] = texts[i];  // the database converts the text to the column's type
  }
  if (const Result<bool> done = insert(cells); !done) return fail(done.error());
  return {};
}

Result<std::int64_t> SweepTable::merge(const std::string& path) {
  Result<store::Database> part = store::Database::open(path, store::OpenMode::read_only);
  if (!part) return fail(std::move(part.error()));
  const Result<std::string> plan = part->text("SELECT value FROM property WHERE name = 'plan'");
  if (!plan) return fail(plan.error());
  if (*plan != plan_) return fail(ErrorCode::conflict, path, "This table belongs to another sweep.", "Merge only the parts of one sweep.");
  Result<store::Statement> select = part->prepare("SELECT * FROM run ORDER BY number");
  if (!select) return fail(std::move(select.error()));
  std::int64_t added = 0;
  for (;;) {
    const Result<bool> row = select->step();
    if (!row) return fail(row.error());
    if (!*row) return added;
    std::vector<std::string> texts(columns_.size());
    std::vector<store::Value> cells(columns_.size());
    for (int i = 0; i < std::min(select->columns(), static_cast<int>(columns_.size())); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (select->is_null(i)) continue;
      texts[at] = select->text(i);
      cells[at] = texts[at];
    }
    cells[0] = select->integer(0);
    const Result<bool> done = insert(cells);
    if (!done) return fail(done.error());
    added += *done ? 1 : 0;
  }
}

Result<std::string> SweepTable::csv() {
  const Result<store::Rows> rows = connection_->query("SELECT * FROM " + table_ + " ORDER BY number");
  if (!rows) return fail(rows.error());
  sweep::Results results{columns_, {}};
  results.cells.resize(rows->size());
  for (std::size_t r = 0; r < rows->size(); ++r)
    for (std::size_t i = 0; i < columns_.size(); ++i) results.cells[r].push_back(rows->is_null(r, i) ? "" : rows->text(r, i));
  return sweep::to_csv(results);
}

}  // namespace ugoki::cli
