#pragma once
// Tables of results of `ugoki bake`: SQLite files, or tables in the PostgreSQL database of a shared library.

#include <cstdint>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::sweep {

/// Location of a table of results.
struct TableAddress {
  std::string location;  ///< path of an SQLite file, or "postgresql://user:password@host:port/database"
  std::string name;      ///< name of the sweep in a PostgreSQL database, where the table is ugoki.sweep_NAME; empty for SQLite
};
/// Checks that an address of PostgreSQL has a valid name, and that the path of an SQLite file has none.
[[nodiscard]] Result<void> check_address(const TableAddress& address);
/// Quoted name of the table of runs, for SQL statements.
[[nodiscard]] std::string table_name(const TableAddress& address);
/// `name` as identifier of SQL, in double quotes; inner quotes are doubled.
[[nodiscard]] std::string quoted(const std::string& name);

/// Rows of a table as texts.
struct Results {
  std::vector<std::string> columns;             ///< names
  std::vector<std::vector<std::string>> cells;  ///< [runs][columns]; empty text: no value
};
/// Reads columns of all runs that have the status `done`, ordered by number. Errors: no such table or column.
[[nodiscard]] Result<Results> read_columns(const TableAddress& address, const std::vector<std::string>& columns);
/// Reads all columns of all runs, ordered by number. Errors: no such table; more than `limit` runs.
[[nodiscard]] Result<Results> read_results(const TableAddress& address, std::uint64_t limit);
/// Returns rows as CSV (RFC 4180, LF).
[[nodiscard]] std::string to_csv(const Results& results);

/// A table that was found.
struct FoundTable {
  TableAddress address;
  std::string name;        ///< file name, or name of the sweep
  std::uint64_t runs = 0;  ///< number of rows
};
/// The tables of results among the files *.db of a folder, newest first, at most 200. Other files are ignored.
[[nodiscard]] std::vector<FoundTable> find_tables(const std::string& folder);
/// The sweeps in a PostgreSQL database, by name; none in a database without sweeps. Errors: the server cannot be reached.
[[nodiscard]] Result<std::vector<FoundTable>> find_sweeps(const std::string& location);

}  // namespace ugoki::sweep
