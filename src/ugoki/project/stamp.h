#pragma once
// The stamp of a project file: shows whether a write-ahead log belongs to the database file beside it. Internal to project.
//
// SQLite does not record to which file a -wal file belongs. If the project is replaced while its log remains (after a crash, by a copy or
// a checkout), SQLite would write the pages of the log into the wrong file. Every transaction therefore writes one row: a new random stamp
// and the stamp of the transaction before it. A log belongs to a file if the stamp in the file is the one before the log's first
// transaction, or the stamp of a transaction in the log (a part of the log is then merged already).

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::project {

using Stamp = std::array<std::byte, 16>;

/// The row of the table `stamp`.
struct StampRow {
  Stamp stamp{}, previous{};
  friend bool operator==(const StampRow&, const StampRow&) = default;
};

/// SQL that creates the table.
inline constexpr const char* stamp_table = R"(
CREATE TABLE stamp (
  number INTEGER PRIMARY KEY NOT NULL CHECK (number = 1),
  mark   TEXT NOT NULL,
  value  BLOB NOT NULL
) STRICT;
)";

/// Replaces the row by a new stamp that follows the present one. Call in each write transaction.
[[nodiscard]] Result<void> advance_stamp(store::Database& database);
/// The row; empty optional if the file has no such table (version 1).
[[nodiscard]] Result<std::optional<StampRow>> read_stamp(store::Database& database);
/// The row on a database page of its own; empty optional if the page contains something else.
[[nodiscard]] std::optional<StampRow> stamp_on_page(std::span<const std::byte> page);
/// Error `conflict` if the -wal file beside `path` belongs to another database file. Changes nothing. Works while a program edits the file.
[[nodiscard]] Result<void> check_log(const std::string& path);

}  // namespace ugoki::project
