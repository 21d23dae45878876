#include "ugoki/sweep/results.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include "ugoki/store/connection.h"

namespace ugoki::sweep {
namespace {

namespace fs = std::filesystem;

/// A table of runs that is open for reading.
struct OpenTable {
  std::unique_ptr<store::Connection> connection;
  std::vector<std::string> columns;
};

Result<OpenTable> open_table(const TableAddress& address) {
  if (Result<void> good = check_address(address); !good) return fail(std::move(good.error()));
  const bool server = store::is_postgres(address.location);
  OpenTable table;
  if (server) {
    Result<std::unique_ptr<store::Connection>> opened = store::postgres_connection(address.location, true);
    if (!opened) return fail(std::move(opened.error()));
    table.connection = std::move(*opened);
  } else {
    Result<store::Database> opened = store::Database::open(address.location, store::OpenMode::read_only);
    if (!opened) return fail(std::move(opened.error()));
    table.connection = store::sqlite_connection(std::move(*opened));
  }
  const Result<store::Rows> known = table.connection->query(
      server ? "SELECT column_name::text FROM information_schema.columns WHERE table_schema = 'ugoki' AND table_name = ?1 ORDER BY "
               "ordinal_position"
             : "SELECT name FROM pragma_table_info(?1)",
      {server ? "sweep_" + address.name : std::string("run")});
  if (!known) return fail(known.error());
  for (std::size_t i = 0; i < known->size(); ++i) table.columns.push_back(known->text(i, 0));
  if (std::ranges::find(table.columns, "status") == table.columns.end())
    return fail(ErrorCode::unknown, server ? "--name " + address.name : address.location, "There is no table of `ugoki bake` here.",
                "Name the file or the database that --table named.");
  return table;
}

Results results_of(std::vector<std::string> columns, const store::Rows& rows) {
  Results out{std::move(columns), {}};
  out.cells.resize(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t i = 0; i < out.columns.size(); ++i) out.cells[r].push_back(rows.is_null(r, i) ? "" : rows.text(r, i));
  return out;
}

}  // namespace

std::string quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

std::string table_name(const TableAddress& address) {
  return store::is_postgres(address.location) ? quoted("sweep_" + address.name) : "run";
}

Result<void> check_address(const TableAddress& address) {
  const bool server = store::is_postgres(address.location);
  if (!server && !address.name.empty())
    return fail(ErrorCode::conflict, "--name", "Only sweeps in a PostgreSQL database have a name.",
                "Leave out --name, or give --table postgresql://host/database.");
  constexpr std::size_t max_name = 50;  // the table is named sweep_NAME, and PostgreSQL limits names to 63 bytes
  const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (server && (address.name.empty() || address.name.size() > max_name || !std::ranges::all_of(address.name, allowed)))
    return fail(ErrorCode::syntax, "--name " + address.name,
                "A sweep in a PostgreSQL database needs a name of 1 to " + std::to_string(max_name) + " small letters, digits and '_'.",
                "Write, for example, --name walk_push.");
  return {};
}

Result<Results> read_columns(const TableAddress& address, const std::vector<std::string>& columns) {
  const Result<OpenTable> table = open_table(address);
  if (!table) return fail(table.error());
  std::string list, sql;
  for (const std::string& name : table->columns) list += (list.empty() ? "" : ", ") + name;
  for (const std::string& name : columns) {
    if (std::ranges::find(table->columns, name) == table->columns.end())
      return fail(ErrorCode::unknown, name, "The table has no such column.", "Use one of: " + list + ".");
    sql += (sql.empty() ? "SELECT " : ", ") + quoted(name);
  }
  const Result<store::Rows> rows =
      table->connection->query(sql + " FROM " + table_name(address) + " WHERE status = 'done' ORDER BY number");
  if (!rows) return fail(rows.error());
  return results_of(columns, *rows);
}

Result<Results> read_results(const TableAddress& address, std::uint64_t limit) {
  const Result<OpenTable> table = open_table(address);
  if (!table) return fail(table.error());
  const Result<store::Rows> rows =
      table->connection->query("SELECT * FROM " + table_name(address) + " ORDER BY number LIMIT " + std::to_string(limit + 1));
  if (!rows) return fail(rows.error());
  if (rows->size() > limit)
    return fail(ErrorCode::range, address.name.empty() ? address.location : address.name,
                "The table has more than " + std::to_string(limit) + " runs.", "Draw it with `ugoki bake plot`.");
  return results_of(table->columns, *rows);
}

std::string to_csv(const Results& results) {
  std::string out;
  const auto add = [&out](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i)
      out += (i > 0 ? "," : "") + (cells[i].find_first_of(",\"\n\r") == std::string::npos ? cells[i] : quoted(cells[i]));
    out += '\n';
  };
  add(results.columns);
  for (const auto& row : results.cells) add(row);
  return out;
}

std::vector<FoundTable> find_tables(const std::string& folder) {
  constexpr std::size_t max_files = 2000, max_tables = 200;
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code ec;
  for (fs::directory_iterator i(folder, ec), end; !ec && i != end && files.size() < max_files; i.increment(ec)) {
    std::error_code none;
    if (i->path().extension() == ".db" && i->is_regular_file(none)) files.emplace_back(i->last_write_time(none), i->path());
  }
  std::ranges::sort(files, std::greater());
  std::vector<FoundTable> out;
  for (const auto& [time, path] : files) {
    if (out.size() == max_tables) break;
    Result<store::Database> database = store::Database::open(path.string(), store::OpenMode::read_only);
    if (!database) continue;
    const Result<std::string> plan = database->text("SELECT value FROM property WHERE name = 'plan'");
    if (!plan || plan->empty()) continue;
    if (const Result<std::int64_t> runs = database->integer("SELECT count(*) FROM run"))
      out.push_back({{path.string(), ""}, path.filename().string(), static_cast<std::uint64_t>(*runs)});
  }
  return out;
}

Result<std::vector<FoundTable>> find_sweeps(const std::string& location) {
  Result<std::unique_ptr<store::Connection>> connection = store::postgres_connection(location, true);
  if (!connection) return fail(std::move(connection.error()));
  std::vector<FoundTable> out;
  const Result<store::Rows> exists =
      (*connection)->query("SELECT table_name::text FROM information_schema.tables WHERE table_schema = 'ugoki' AND table_name = 'sweep'");
  if (!exists) return fail(exists.error());
  if (exists->empty()) return out;
  const Result<store::Rows> names = (*connection)->query("SELECT name FROM sweep ORDER BY name LIMIT 200");
  if (!names) return fail(names.error());
  for (std::size_t i = 0; i < names->size(); ++i) {
    const TableAddress address{location, names->text(i, 0)};
    if (!check_address(address)) continue;
    if (const Result<store::Rows> count = (*connection)->query("SELECT count(*) FROM " + table_name(address)); count && !count->empty())
      out.push_back({address, address.name, static_cast<std::uint64_t>(count->integer(0, 0))});
  }
  return out;
}

}  // namespace ugoki::sweep
