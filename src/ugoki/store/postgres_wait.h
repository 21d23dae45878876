#pragma once
// Waits for a PostgreSQL server with time limits on the client's side, so that a stopped server or a broken network is an error and not
// an endless wait. Internal to store.

#include <libpq-fe.h>

#include <chrono>
#include <functional>

namespace ugoki::store {

/// If a server sends nothing for this time, a second connection tests whether the server still runs.
inline constexpr std::chrono::seconds max_silence{3};
/// Time limit for making a connection, s, as text for libpq (connect_timeout).
inline constexpr const char* connect_limit = "3";
/// Time limit of one statement, set on the server, as text for SQL. Upgrades and VACUUM have no limit.
inline constexpr const char* statement_limit = "60s";

/// A statement without an answer for this time fails even if the server accepts connections: the server process that runs it may be
/// stopped.
inline constexpr std::chrono::seconds max_statement_silence{90};

/// Sends the remaining bytes of the last statement on the non-blocking connection `handle`, and waits for its results.
/// @param limit maximum time in which nothing is received or sent
/// @param alive tests on another connection whether the server runs; called whenever nothing was received or sent for max_silence
/// @return the last result, or the first that is an error, as PQexec does; null: the server does not respond, and `handle` must be closed
[[nodiscard]] PGresult* wait_for_result(PGconn* handle, std::chrono::seconds limit, const std::function<bool()>& alive);

}  // namespace ugoki::store
