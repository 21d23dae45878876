#pragma once
// Damage of a write-ahead log (-wal file). SQLite reads a log up to the first page that fails its checksum, ignores the rest without a
// message, and removes the log when the file is closed. Used by `store` and `project`.

#include <cstdint>
#include <optional>
#include <string>

#include "ugoki/base/result.h"

namespace ugoki::store {

/// The unreadable part of a log.
struct LogDamage {
  std::uint64_t offset = 0;        ///< byte of the log file at which the readable part ends
  std::uint64_t transactions = 0;  ///< number of transactions that begin to be unreadable there, at least; 0: unknown
  friend bool operator==(const LogDamage&, const LogDamage&) = default;
};

/// Empty optional if the file is missing or SQLite can read all of its transactions. A transaction that was not completed because the
/// program was killed, and log frames left over from before SQLite began the log again, are not damage. After a power failure the last
/// transaction may be reported although it was not confirmed: nothing in the log distinguishes the two cases.
[[nodiscard]] std::optional<LogDamage> find_log_damage(const std::string& log);

/// Whether a damaged log is only reported or also copied.
enum class DamagedLog : std::uint8_t { report, keep_copy };
/// If the log beside the database file `path` is damaged: a warning that names log, byte and number of changes. With `keep_copy`, the
/// file and its log are copied first (rescue.h), and the warning names the copy. Error: the copy could not be written.
[[nodiscard]] Result<std::optional<Problem>> check_log_damage(const std::string& path, DamagedLog handling);

}  // namespace ugoki::store
