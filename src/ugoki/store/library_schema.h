#pragma once
// The tables of a library, and the upgrade of older versions. Internal to store.

#include "ugoki/base/result.h"
#include "ugoki/store/connection.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {

inline constexpr std::int64_t library_application_id = 0x55474b4c;  // "UGKL" in ASCII: marks the file as a library
inline constexpr std::int64_t library_version = 3;                  ///< schema version of SQLite files
inline constexpr std::int64_t server_version = 4;                   ///< schema version on PostgreSQL

/// SQLite: checks that the file is a library of a version that this program can read. An empty file is accepted.
[[nodiscard]] Result<void> check_library(Database& database);
inline constexpr std::int64_t first_readable_version = 2;  ///< SQLite: libraries since this version can be read without an upgrade

/// SQLite: creates the tables, or upgrades those of an older version, in one transaction.
[[nodiscard]] Result<void> migrate_library(Connection& connection);

/// PostgreSQL: creates the schema `ugoki` with its tables, or upgrades those of an older version. A newer version is refused.
/// @param read_only never write: a database without a library, or with an older version, is refused
[[nodiscard]] Result<void> prepare_postgres(Connection& connection, bool read_only);

}  // namespace ugoki::store
