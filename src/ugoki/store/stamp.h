#pragma once
// The stamp of a project file or library file. It shows whether a write-ahead log belongs to the database file beside it. Used by the
// modules store and project.
//
// SQLite does not record to which file a -wal file belongs. If the file is replaced while its log remains (after a crash, by a copy or
// a checkout), SQLite would write the pages of the log into the wrong file. Every transaction therefore writes one row: a new random stamp
// and the stamp of the transaction before it. A log belongs to a file if the stamp in the file is the one before the log's first
// transaction, or the stamp of a transaction in the log (a part of the log is then merged already).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {

using Stamp = std::array<std::byte, 16>;

/// The single row of the table `stamp`.
struct StampRow {
  Stamp stamp{}, previous{};
  friend bool operator==(const StampRow&, const StampRow&) = default;
};

/// SQL that creates the table `stamp`.
inline constexpr const char* stamp_table = R"(
CREATE TABLE stamp (
  number INTEGER PRIMARY KEY NOT NULL CHECK (number = 1),
  mark   TEXT NOT NULL,
  value  BLOB NOT NULL
) STRICT;
)";

/// Replaces the row: a new random stamp, with the present stamp as the previous one. Call in each write transaction.
[[nodiscard]] Result<void> advance_stamp(Database& database);
/// Writes a stamp, in a transaction of its own, if the table `stamp` has no valid row.
[[nodiscard]] Result<void> ensure_stamp(Database& database);
/// Reads the row of the table `stamp`; empty optional if the file has no such table (version 1).
[[nodiscard]] Result<std::optional<StampRow>> read_stamp(Database& database);
/// Reads the row from the database page that contains only this row; empty optional if the page contains something else.
[[nodiscard]] std::optional<StampRow> stamp_on_page(std::span<const std::byte> page);
/// Error `conflict` if the -wal file beside `path` belongs to another database file. Changes nothing. Works while a program edits the file.
[[nodiscard]] Result<void> check_log(const std::string& path);

/// The stamps of the committed transactions in a log.
struct LogStamps {
  bool has_transactions = false;
  std::vector<StampRow> rows;
  std::uint32_t page_size = 0;       ///< page size of the database, bytes
  std::vector<std::uint32_t> pages;  ///< numbers of the pages with the stamp, counted from 1, each once; VACUUM moves the stamp
};
/// Reads the -wal file `log` as SQLite does: up to the first frame with another salt or a wrong checksum. A missing file has no
/// transactions.
[[nodiscard]] LogStamps read_log(const std::string& log);
/// True if the log belongs to the database file with the stamp `file`. An empty `file` means that the file has no table `stamp`.
[[nodiscard]] bool belongs(const std::optional<StampRow>& file, const LogStamps& log);

}  // namespace ugoki::store
