#pragma once
// The tables of a library and how older versions are brought up to date. Internal to store.

#include "ugoki/base/result.h"
#include "ugoki/store/connection.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {

inline constexpr std::int64_t library_application_id = 0x55474b4c;  // "UGKL"
inline constexpr std::int64_t library_version = 2;
inline constexpr std::int64_t server_version = 4;  ///< of a library on a server

/// SQLite: refuses what is not a library of a version that this program knows. An empty file is good.
[[nodiscard]] Result<void> check_library(Database& database);
/// SQLite: makes the tables, or brings those of an older version up to date, in one transaction.
[[nodiscard]] Result<void> migrate_library(Connection& connection);

/// PostgreSQL: makes the schema `ugoki` and its tables where there are none; refuses a newer version.
/// @param read_only a database without library is refused
[[nodiscard]] Result<void> prepare_postgres(Connection& connection, bool read_only);

}  // namespace ugoki::store
